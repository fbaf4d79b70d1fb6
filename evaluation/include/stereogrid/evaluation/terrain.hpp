// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/evaluation/scores.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::evaluation {

/// Ranges and tolerance of terrain scores. Cells of 0.2 m: 8 and 13 m, 0.4 m; cells below 0.1 m, a robot's: 2 and 4 m,
/// 0.1 m.
struct TerrainScale {
  std::array<Band, 2> ranges;
  double tolerance_m{0};
};
/// Scale of grids with cells of this size.
[[nodiscard]] STEREOGRID_EXPORT TerrainScale terrain_scale(double cell_size_m);

/// Counts of docs/evaluation.md in one range, over all frames.
struct TerrainCounts {
  std::size_t drivable{0};
  std::size_t drivable_free{0};
  std::size_t drivable_occupied{0};
  std::size_t edges{0};  ///< cells
  std::size_t edges_found{0};
  std::size_t rises{0};  ///< cells
  std::size_t rises_found{0};
  std::size_t objects{0};  ///< objects × frames
  std::size_t objects_found{0};
  std::size_t deadly{0};  ///< cells that must not be free
  std::size_t deadly_free{0};
};

/// A share of those counts, for tables and files.
struct TerrainMetric {
  std::string_view name;
  std::string_view title;
  std::size_t TerrainCounts::*part;
  std::size_t TerrainCounts::*whole;
};
inline constexpr std::array<TerrainMetric, 6> terrain_metrics{{
    {"drivable_free", "drivable, free", &TerrainCounts::drivable_free, &TerrainCounts::drivable},
    {"drivable_occupied", "drivable, occupied", &TerrainCounts::drivable_occupied, &TerrainCounts::drivable},
    {"objects_found", "objects found", &TerrainCounts::objects_found, &TerrainCounts::objects},
    {"rises_found", "steps up found", &TerrainCounts::rises_found, &TerrainCounts::rises},
    {"edges_found", "edges found", &TerrainCounts::edges_found, &TerrainCounts::edges},
    {"deadly_share", "deadly share", &TerrainCounts::deadly_free, &TerrainCounts::deadly},
}};

/// The smallest step that is found, with all larger ones, in 90 % of its cells; NaN: none.
struct SmallestStep {
  Band range;
  double up_m{std::numeric_limits<double>::quiet_NaN()};
  double down_m{std::numeric_limits<double>::quiet_NaN()};
};

/// A zone of a course, in the near range, over all frames.
struct ZoneScore {
  TruthZone zone;
  std::size_t marks{0};  ///< obstacle and drop cells
  std::size_t marks_found{0};
  std::size_t deadly{0};
  std::size_t deadly_free{0};
  std::size_t drivable{0};
  std::size_t drivable_occupied{0};

  /// Half of a hazard's marks are found.
  [[nodiscard]] bool is_found() const { return marks > 0 && 2 * marks_found >= marks; }
  /// More than a twentieth of the drivable cells is occupied.
  [[nodiscard]] bool is_false() const { return 20 * drivable_occupied > drivable; }
};

struct TerrainSummary {
  TerrainScale scale;
  std::size_t frames{0};
  std::array<TerrainCounts, 2> ranges;
  std::vector<SmallestStep> steps;  ///< ranges with steps of several heights
  std::vector<ZoneScore> zones;     ///< zones that were seen
};

/// Scores one series of grids against terrain truth.
class STEREOGRID_EXPORT TerrainScores {
 public:
  /// `probability`: P(occupied) on `grid`, 0.5 = unknown. A frame without terrain truth is skipped. Throws InputError
  /// where the cells of grid and truth do not coincide.
  void add(View<const float> probability, const GridGeometry& grid, const FrameTruth& truth,
           const TruthGrid& truth_grid);

  [[nodiscard]] TerrainSummary summary() const;

 private:
  struct Found {
    std::size_t cells{0};
    std::size_t found{0};
  };
  class Frame;
  void add_cell(const Frame& frame, CellIndex cell);
  /// By quarter of the far range and height in whole centimetres.
  std::map<std::pair<int, int>, Found> steps_;
  TerrainSummary summary_;
};

/// Free cells, P(occupied) < 0.5, that are labelled, by their witness; and those of them that are occupied in truth,
/// where no cell around is found to be occupied.
struct WitnessSummary {
  std::size_t ground{0};
  std::size_t ground_occupied{0};
  std::size_t memory{0};
  std::size_t memory_occupied{0};
  std::size_t source{0};
  std::size_t source_occupied{0};
  std::size_t frames{0};
  std::size_t failed{0};  ///< frames with such an occupied cell
  /// 95 % bound of the share of such frames, 3/frames, if the frames are independent; NaN: there are some.
  double failed_at_most{std::numeric_limits<double>::quiet_NaN()};
};

/// Scores witnesses of free cells against labels.
class STEREOGRID_EXPORT WitnessScores {
 public:
  /// `probability`, `witness`: on labels.geometry. Frames without witnesses are skipped.
  void add(View<const float> probability, View<const CellWitness> witness, const Labels& labels);

  [[nodiscard]] WitnessSummary summary() const;

 private:
  WitnessSummary summary_;
};

}  // namespace stereogrid::evaluation
