// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/tally.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace stereogrid::bench {
namespace {

template <class Array>
void add_each(Array& sums, const Array& others) {
  std::ranges::transform(sums, others, sums.begin(), std::plus<>{});
}

}  // namespace

void DisparityTally::add(float disparity, float truth) {
  ++points_;
  if (!(disparity > 0)) return;
  const float error{std::abs(disparity - truth)};
  ++matched_;
  wrong_by_3_ += error > 3 ? 1 : 0;
  wrong_by_1_ += error > 1 ? 1 : 0;
  const auto bin{static_cast<std::size_t>(error * bins_per_px)};
  ++errors_[std::min(bin, errors_.size() - 1)];
}

DisparityTally& DisparityTally::operator+=(const DisparityTally& other) {
  points_ += other.points_;
  matched_ += other.matched_;
  wrong_by_3_ += other.wrong_by_3_;
  wrong_by_1_ += other.wrong_by_1_;
  add_each(errors_, other.errors_);
  return *this;
}

double DisparityTally::median_error_px() const {
  if (matched_ == 0) return 0;
  Count below{0};
  std::size_t bin{0};
  while ((below += errors_[bin]) * 2 < matched_) ++bin;
  return std::min((static_cast<double>(bin) + 0.5) / bins_per_px, 10.0);
}

void LabelTally::add(Surface label, const TruthPoint& point) {
  const Count away{point.near_contact ? 0 : 1};
  ++points;
  points_away += away;
  if (label == Surface::other) return;
  ++matched;
  matched_away += away;
  if (label != point.surface) return;
  ++right;
  right_away += away;
}

LabelTally& LabelTally::operator+=(const LabelTally& other) {
  points += other.points;
  matched += other.matched;
  right += other.right;
  matched_away += other.matched_away;
  right_away += other.right_away;
  points_away += other.points_away;
  return *this;
}

void Reliability::add(float confidence, bool is_right) {
  const double clamped{confidence > 0 ? std::min(static_cast<double>(confidence), 1.0) : 0.0};
  Bin& bin{table_[static_cast<std::size_t>(std::min(static_cast<int>(clamped * bins), bins - 1))]};
  ++bin.points;
  bin.right += is_right ? 1 : 0;
  bin.confidence_sum += clamped;
}

Reliability& Reliability::operator+=(const Reliability& other) {
  for (std::size_t i{0}; i < bins; ++i) {
    table_[i].points += other.table_[i].points;
    table_[i].right += other.table_[i].right;
    table_[i].confidence_sum += other.table_[i].confidence_sum;
  }
  return *this;
}

Count Reliability::points() const {
  Count sum{0};
  for (const Bin& bin : table_) sum += bin.points;
  return sum;
}

double Reliability::expected_calibration_error() const {
  if (points() == 0) return 0;
  double sum{0};
  for (const Bin& bin : table_) sum += std::abs(bin.confidence_sum - static_cast<double>(bin.right));
  return sum / static_cast<double>(points());
}

bool is_right(float disparity, float truth) {
  return std::abs(disparity - truth) <= 1;
}

MatcherTally& MatcherTally::operator+=(const MatcherTally& other) {
  road += other.road;
  obstacle += other.obstacle;
  all += other.all;
  road_label += other.road_label;
  obstacle_label += other.obstacle_label;
  reliability += other.reliability;
  return *this;
}

}  // namespace stereogrid::bench
