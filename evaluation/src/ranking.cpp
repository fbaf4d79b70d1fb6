// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ranking.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace stereogrid::evaluation {
namespace {

constexpr double nothing{std::numeric_limits<double>::quiet_NaN()};

double total(std::span<const GroupCounts> groups, Kind kind) {
  double sum{0};
  for (const GroupCounts& group : groups) sum += group.*kind;
  return sum;
}

}  // namespace

Ranking::Ranking(std::vector<double> values, std::size_t groups_max) {
  std::sort(values.begin(), values.end(), std::greater{});
  const std::size_t smallest_group{(values.size() + groups_max - 1) / std::max<std::size_t>(groups_max, 1)};
  std::size_t in_group{0};
  for (std::size_t i{0}; i < values.size(); ++i) {
    ++in_group;
    const bool last{i + 1 == values.size()};
    if (!last && (in_group < smallest_group || values[i + 1] == values[i])) continue;
    lowest_.push_back(values[i]);
    in_group = 0;
  }
}

std::size_t Ranking::group_of(double value) const {
  const auto found{std::lower_bound(lowest_.begin(), lowest_.end(), value, std::greater{})};
  return static_cast<std::size_t>(found - lowest_.begin());
}

double area_under_roc(std::span<const GroupCounts> groups, Kind positives, Kind negatives) {
  double above{0};
  double pairs{0};
  for (const GroupCounts& group : groups) {
    pairs += group.*negatives * (above + 0.5 * group.*positives);
    above += group.*positives;
  }
  const double all{above * total(groups, negatives)};
  return all > 0 ? pairs / all : nothing;
}

double recall_at(std::span<const GroupCounts> groups, Kind positives, Kind negatives, double rate) {
  const double all_positives{total(groups, positives)};
  const double all_negatives{total(groups, negatives)};
  if (all_positives == 0 || all_negatives == 0) return nothing;
  double allowed{rate * all_negatives};
  double found{0};
  for (const GroupCounts& group : groups) {
    if (group.*negatives > allowed) return (found + group.*positives * allowed / (group.*negatives)) / all_positives;
    allowed -= group.*negatives;
    found += group.*positives;
  }
  return 1;
}

std::vector<RocPoint> roc_of(std::span<const GroupCounts> groups, Kind positives, Kind negatives) {
  const double all_positives{total(groups, positives)};
  const double all_negatives{total(groups, negatives)};
  if (all_positives == 0 || all_negatives == 0) return {};
  std::vector<RocPoint> points{{0, 0}};
  double found{0};
  double alarms{0};
  for (const GroupCounts& group : groups) {
    found += group.*positives;
    alarms += group.*negatives;
    const RocPoint point{alarms / all_negatives, found / all_positives};
    const std::size_t n{points.size()};
    // the middle of a level stretch says nothing
    if (n > 1 && points[n - 1].recall == point.recall && points[n - 2].recall == point.recall) points.pop_back();
    points.push_back(point);
  }
  return points;
}

BlockResampler::BlockResampler(std::size_t frames)
    : block_{static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(frames))))}, times_(frames) {}

const std::vector<int>& BlockResampler::draw() {
  std::fill(times_.begin(), times_.end(), 0);
  const std::size_t frames{times_.size()};
  for (std::size_t drawn{0}; drawn < frames; drawn += block_) {
    const std::size_t first{static_cast<std::size_t>(random_() % frames)};
    for (std::size_t i{0}; i < block_; ++i) ++times_[(first + i) % frames];
  }
  return times_;
}

double quantile(std::vector<double> values, double share) {
  const std::size_t all{values.size()};
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty() || 2 * values.size() < all) return std::numeric_limits<double>::quiet_NaN();
  const auto place{static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)))};
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

}  // namespace stereogrid::evaluation
