// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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

}  // namespace stereogrid::evaluation
