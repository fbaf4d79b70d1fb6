// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <random>
#include <span>
#include <vector>

#include "stereogrid/evaluation/scores.hpp"

namespace stereogrid::evaluation {

/// Values in groups from the largest to the smallest; equal values share one.
class Ranking {
 public:
  /// About `groups_max` groups of about the same size at most; as many as there are values: every value its own.
  Ranking(std::vector<double> values, std::size_t groups_max);

  [[nodiscard]] std::size_t size() const { return lowest_.size(); }
  [[nodiscard]] std::size_t group_of(double value) const;
  /// The smallest value of a group.
  [[nodiscard]] double lowest(std::size_t group) const { return lowest_[group]; }

 private:
  std::vector<double> lowest_;
};

/// Number of cells of each kind with probabilities of one group.
struct GroupCounts {
  double occupied{0};
  double free{0};
  double hidden_occupied{0};
  double hidden_free{0};
  double clear_free{0};  ///< free, with no occupied cell beside it
};
using Kind = double GroupCounts::*;

/// P(a positive is ranked above a negative); ties count half. NaN where one kind is missing.
[[nodiscard]] double area_under_roc(std::span<const GroupCounts> groups, Kind positives, Kind negatives);

/// Share of the positives found when `rate` of the negatives are taken for positive; straight between the corners of
/// the characteristic. NaN where one kind is missing.
[[nodiscard]] double recall_at(std::span<const GroupCounts> groups, Kind positives, Kind negatives, double rate);

[[nodiscard]] std::vector<RocPoint> roc_of(std::span<const GroupCounts> groups, Kind positives, Kind negatives);

/// Draws frames with replacement in blocks of neighbours, since a frame is much like the one before it; the last frame
/// is followed by the first (circular block bootstrap, Politis and Romano 1992). Blocks are √n frames long. The same
/// draws on every machine.
class BlockResampler {
 public:
  explicit BlockResampler(std::size_t frames);
  /// Number of draws of each frame; whole blocks, so n draws or slightly more.
  [[nodiscard]] const std::vector<int>& draw();

 private:
  std::size_t block_;
  std::vector<int> times_;
  std::mt19937_64 random_{20120901};
};

/// The value that `share` of the values are below, NaN left out; NaN where most are NaN.
[[nodiscard]] double quantile(std::vector<double> values, double share);

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
