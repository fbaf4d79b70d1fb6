// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "ranking.hpp"
#include "stereogrid/evaluation/scores.hpp"

namespace stereogrid::evaluation {

struct CalibrationBin {
  double cells{0};
  double probability{0};  ///< sum
  double occupied{0};
};

/// Sums over cells and columns that every figure of a Summary follows from. Those of frames add up to those of a drive.
struct Totals {
  double occupied{0};
  double free{0};
  double hidden_occupied{0};
  double loss_occupied{0};  ///< −ln p
  double loss_free{0};      ///< −ln(1 − p)
  double squared_error{0};
  double found{0};         ///< occupied, p > 0.55
  double false_alarms{0};  ///< free, p > 0.55
  double found_free{0};    ///< free, p < 0.45
  double missed{0};        ///< occupied, p < 0.45
  double hidden_missed{0};
  double known{0};
  std::array<CalibrationBin, reliability_bins> bins{};
  std::vector<GroupCounts> groups;  ///< by rank of the probability

  double columns{0};
  double depth_error_m{0};
  double depth_bias_m{0};
  double depth_wrong{0};
  double depth_overshoot{0};
  std::vector<double> depth_groups;  ///< columns by rank of |error|

  Totals(std::size_t probability_groups, std::size_t depth_error_groups)
      : groups(probability_groups), depth_groups(depth_error_groups) {}

  void add(const Scores::Cell& cell, const Ranking& probabilities);
  void add(const ColumnDepth& column, const Ranking& errors);
  Totals& operator+=(const Totals& other);
};

/// p as it is scored.
[[nodiscard]] double clipped(float probability);
/// |found − true|.
[[nodiscard]] double depth_error(const ColumnDepth& column);

/// Fills the values (not the intervals) of a summary. `errors`: the ranking of Totals::depth_groups.
void fill_values(const Totals& totals, const Ranking& errors, Summary& summary);

}  // namespace stereogrid::evaluation
