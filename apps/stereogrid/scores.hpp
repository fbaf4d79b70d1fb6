// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "stereogrid/obstacle.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::app {

/// How well probabilities of occupancy tell occupied from free cells.
class CellScores {
 public:
  /// A cell that was seen, and what it truly is.
  void add(float probability, bool occupied);
  /// A cell that nothing of was seen, though something stands there.
  void add_hidden_occupied(float probability);

  struct Summary {
    std::size_t cells{0};
    std::size_t occupied{0};
    double accuracy{0};           ///< p > 0.5 says what the cell is
    double missed{0};             ///< share of the occupied cells with p < 0.45
    double false_alarms{0};       ///< share of the free cells with p > 0.55
    double balanced_log_loss{0};  ///< p clipped to [0.001, 0.999]
    double auc{0};
    double known{0};  ///< share with |p − 0.5| > 0.05
    double hidden_occupied_mean{0};
  };
  /// NaN where there are no cells to say it of.
  [[nodiscard]] Summary summary() const;

 private:
  std::vector<float> occupied_;
  std::vector<float> free_;
  double hidden_sum_{0};
  std::size_t hidden_{0};
};

/// How well the velocities of things that move are found, and whether things that stand still do.
class MotionScores {
 public:
  /// One frame: what stands in it, and what was found. `truth` needs its grid for `is_inside`.
  void add_objects(const FrameTruth& truth, const GridGeometry& grid, const std::vector<Obstacle>& found);
  /// A cell of something static that was seen.
  void add_static_cell(float occupancy, float speed_mps);

  struct Summary {
    std::size_t sightings{0};  ///< moving object × frame
    std::size_t found{0};      ///< of them with a confirmed obstacle within 2 m
    double speed_error_mps{0};
    double direction_error_deg{0};
    std::size_t static_cells{0};
    double static_moving{0};  ///< share of static cells with p > 0.6 and a speed above 1 m/s
  };
  /// Medians; NaN where there is nothing to say it of.
  [[nodiscard]] Summary summary() const;

 private:
  std::size_t sightings_{0};
  std::vector<double> speed_errors_mps_;
  std::vector<double> direction_errors_deg_;
  std::size_t static_cells_{0};
  std::size_t static_moving_{0};
};

}  // namespace stereogrid::app
