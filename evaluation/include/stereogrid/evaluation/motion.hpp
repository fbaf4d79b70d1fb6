// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid::evaluation {

/// A frame of a filtered series beside its exact truth; all grids lie in the vehicle frame.
struct MotionFrame {
  const FrameTruth& truth;
  const TruthGrid& truth_grid;
  const Rig& rig;     ///< rig of the recording
  GridGeometry grid;  ///< grid of the next three
  View<const float> occupancy;
  View<const float> velocity_x;  ///< m/s relative to the ground, vehicle axes; empty: not in the series
  View<const float> velocity_y;
  std::span<const Obstacle> obstacles;
};

/// Times after which cells that a moving object has left are given up.
class STEREOGRID_EXPORT GhostTimes {
 public:
  void add(const MotionFrame& frame);
  /// Seconds from when a cell was first seen free until its p fell below 0.3. A cell that was hidden again or whose
  /// drive ended before that counts with the time until then.
  [[nodiscard]] std::vector<double> seconds() const;
  /// Share of the cells that fell within 0.5 s; cells watched for less are left out. NaN: none.
  [[nodiscard]] double gone_within_half_second() const;

 private:
  struct Left {
    double seconds{0};
    bool fell{false};
  };
  using WorldCell = std::pair<int, int>;
  void watch(const MotionFrame& frame);
  void follow(const MotionFrame& frame);

  std::map<WorldCell, std::optional<std::int64_t>> watched_;  // stamp since which the cell is seen free
  std::vector<Left> left_;
  std::int64_t now_ns_{0};
};

/// Time for which hidden objects stay occupied.
class STEREOGRID_EXPORT HiddenSurvival {
 public:
  void add(const MotionFrame& frame);

  struct Episode {
    double hidden_s{0};    ///< from the first to the last frame of it
    double survived_s{0};  ///< until the mean p of the object's cells was first below 0.5; at most hidden_s
    std::size_t frames{0};
    std::size_t alive{0};  ///< frames with a mean p ≥ 0.5
  };
  [[nodiscard]] std::vector<Episode> episodes() const;

 private:
  struct Open {
    std::int64_t since_ns{0};
    std::int64_t last_ns{0};
    std::optional<std::int64_t> lost_ns;
    Episode counts;
  };
  void extend(std::int64_t id, std::int64_t stamp_ns, double mean);
  void close(std::int64_t id);

  std::set<std::int64_t> seen_;
  std::map<std::int64_t, Open> open_;
  std::vector<Episode> finished_;
};

/// Stability of obstacle ids, and separation of static and dynamic obstacles. Confirmed obstacles only.
class STEREOGRID_EXPORT Identities {
 public:
  void add(const MotionFrame& frame);
  /// Number of id changes of moving objects. The previous obstacle is preferred within 2 m, even if another one is
  /// nearer.
  [[nodiscard]] std::size_t switches() const { return switches_; }
  /// Obstacles × frames farther than 3 m from everything that moves, and how many of them have more than 1 m/s.
  [[nodiscard]] std::size_t standing() const { return standing_; }
  [[nodiscard]] std::size_t standing_with_speed() const { return standing_with_speed_; }

 private:
  std::map<std::int64_t, std::int64_t> id_of_object_;
  std::size_t switches_{0};
  std::size_t standing_{0};
  std::size_t standing_with_speed_{0};
};

/// Figures defined in docs/evaluation.md. Medians; NaN: undefined.
struct MotionSummary {
  static constexpr double nothing{std::numeric_limits<double>::quiet_NaN()};
  std::size_t sightings{0};  ///< moving object × frame
  std::size_t found{0};      ///< found with a confirmed obstacle within 2 m
  double speed_error_mps{nothing};
  double direction_error_deg{nothing};
  double velocity_error_mps{nothing};  ///< length of the difference
  std::size_t id_switches{0};
  std::size_t standing_obstacles{0};
  double standing_with_speed{nothing};  ///< share of them that seem to move
  std::size_t moving_cells{0};          ///< seen, of moving objects, p ≥ 0.5
  double cell_velocity_error_mps{nothing};
  std::size_t static_cells{0};    ///< seen, of objects that stand still
  double static_moving{nothing};  ///< share of them with p > 0.6 and a speed above 1 m/s
  std::size_t left_cells{0};
  double ghost_s{nothing};
  double gone_within_half_second{nothing};
  std::size_t hidden_episodes{0};
  std::size_t hidden_frames{0};
  double hidden_alive{nothing};  ///< share of the hidden frames with a mean p ≥ 0.5
  double hidden_s{nothing};
  double survived_s{nothing};
};

/// Scores of motion. Moving objects are scored from one second after the first frame on, static ones always.
class STEREOGRID_EXPORT MotionScores {
 public:
  void add(const MotionFrame& frame);
  [[nodiscard]] MotionSummary summary() const;

 private:
  void add_objects(const MotionFrame& frame);
  void add_cells(const MotionFrame& frame, bool settled);

  std::optional<std::int64_t> first_ns_;
  std::size_t sightings_{0};
  std::vector<double> speed_errors_mps_;
  std::vector<double> direction_errors_deg_;
  std::vector<double> velocity_errors_mps_;
  std::vector<double> cell_velocity_errors_mps_;
  std::size_t static_cells_{0};
  std::size_t static_moving_{0};
  GhostTimes ghosts_;
  HiddenSurvival hidden_;
  Identities identities_;
};

}  // namespace stereogrid::evaluation
