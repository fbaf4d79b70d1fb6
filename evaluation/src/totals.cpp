// SPDX-License-Identifier: Apache-2.0
#include "totals.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace stereogrid::evaluation {
namespace {

constexpr double called_occupied_above{0.55};
constexpr double called_free_below{0.45};
constexpr double known_beyond{0.05};
constexpr double false_alarm_rate{0.01};

double ratio(double a, double b) {
  return b > 0 ? a / b : std::numeric_limits<double>::quiet_NaN();
}

double calibration_error(const Totals& totals) {
  double error{0};
  for (const CalibrationBin& bin : totals.bins) error += std::abs(bin.probability - bin.occupied);
  return ratio(error, totals.occupied + totals.free);
}

double median(const std::vector<double>& groups, const Ranking& values) {
  double all{0};
  for (const double count : groups) all += count;
  double passed{0};
  for (std::size_t i{0}; i < groups.size(); ++i) {
    passed += groups[i];
    if (passed > 0 && 2 * passed >= all) return values.lowest(i);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

void fill_hidden(const Totals& totals, Summary& summary) {
  constexpr Kind occupied{&GroupCounts::hidden_occupied};
  summary.hidden_recall.value = recall_at(totals.groups, occupied, &GroupCounts::free, false_alarm_rate);
  summary.hidden_recall_strict.value = recall_at(totals.groups, occupied, &GroupCounts::hidden_free, false_alarm_rate);
  summary.hidden_recall_clear.value = recall_at(totals.groups, occupied, &GroupCounts::clear_free, false_alarm_rate);
  summary.hidden_auc.value = area_under_roc(totals.groups, occupied, &GroupCounts::hidden_free);
  summary.hidden_missed.value = ratio(totals.hidden_missed, totals.hidden_occupied);
}

constexpr double nothing{std::numeric_limits<double>::quiet_NaN()};

double total(std::span<const GroupCounts> groups, Kind kind) {
  double sum{0};
  for (const GroupCounts& group : groups) sum += group.*kind;
  return sum;
}

}  // namespace

double clipped(float probability) {
  return std::clamp(static_cast<double>(probability), 0.001, 0.999);
}

double depth_error(const ColumnDepth& column) {
  return std::abs(static_cast<double>(column.found_m) - static_cast<double>(column.truth_m));
}

void Totals::add(const Scores::Cell& cell, const Ranking& probabilities) {
  const double p{clipped(cell.probability)};
  GroupCounts& group{groups[probabilities.group_of(p)]};
  CalibrationBin& bin{bins[std::min(static_cast<std::size_t>(p * reliability_bins), reliability_bins - 1)]};
  bin.cells += 1;
  bin.probability += p;
  known += std::abs(p - 0.5) > known_beyond ? 1 : 0;
  if (cell.occupied) {
    occupied += 1;
    bin.occupied += 1;
    group.occupied += 1;
    loss_occupied -= std::log(p);
    squared_error += (1 - p) * (1 - p);
    found += p > called_occupied_above ? 1 : 0;
    missed += p < called_free_below ? 1 : 0;
  } else {
    free += 1;
    group.free += 1;
    group.clear_free += cell.is_border ? 0 : 1;
    loss_free -= std::log(1 - p);
    squared_error += p * p;
    false_alarms += p > called_occupied_above ? 1 : 0;
    found_free += p < called_free_below ? 1 : 0;
  }
  if (!cell.partly_hidden) return;
  (cell.occupied ? group.hidden_occupied : group.hidden_free) += 1;
  if (!cell.occupied) return;
  hidden_occupied += 1;
  hidden_missed += p < called_free_below ? 1 : 0;
}

void Totals::add(const ColumnDepth& column, const Ranking& errors) {
  const double error{depth_error(column)};
  constexpr double rounding_m{1e-4};  // cells begin at multiples of their size, where the limit lies, too
  const bool wrong{error > 0.1 * static_cast<double>(column.truth_m) + 1 + rounding_m};
  columns += 1;
  depth_error_m += error;
  depth_bias_m += column.found_m > column.truth_m ? error : -error;
  depth_wrong += wrong ? 1 : 0;
  depth_overshoot += wrong && column.found_m > column.truth_m ? 1 : 0;
  depth_groups[errors.group_of(error)] += 1;
}

Totals& Totals::operator+=(const Totals& other) {
  for (double Totals::*sum :
       {&Totals::occupied, &Totals::free, &Totals::hidden_occupied, &Totals::loss_occupied, &Totals::loss_free,
        &Totals::squared_error, &Totals::found, &Totals::false_alarms, &Totals::found_free, &Totals::missed,
        &Totals::hidden_missed, &Totals::known, &Totals::columns, &Totals::depth_error_m, &Totals::depth_bias_m,
        &Totals::depth_wrong, &Totals::depth_overshoot}) {
    this->*sum += other.*sum;
  }
  for (std::size_t i{0}; i < bins.size(); ++i) {
    bins[i].cells += other.bins[i].cells;
    bins[i].probability += other.bins[i].probability;
    bins[i].occupied += other.bins[i].occupied;
  }
  for (std::size_t i{0}; i < groups.size(); ++i) {
    groups[i].occupied += other.groups[i].occupied;
    groups[i].free += other.groups[i].free;
    groups[i].hidden_occupied += other.groups[i].hidden_occupied;
    groups[i].hidden_free += other.groups[i].hidden_free;
    groups[i].clear_free += other.groups[i].clear_free;
  }
  for (std::size_t i{0}; i < depth_groups.size(); ++i) depth_groups[i] += other.depth_groups[i];
  return *this;
}

void fill_values(const Totals& t, const Ranking& errors, Summary& summary) {
  const double cells{t.occupied + t.free};
  summary.balanced_log_loss.value = 0.5 * (ratio(t.loss_occupied, t.occupied) + ratio(t.loss_free, t.free));
  summary.brier.value = ratio(t.squared_error, cells);
  summary.auc.value = area_under_roc(t.groups, &GroupCounts::occupied, &GroupCounts::free);
  summary.iou_occupied.value = ratio(t.found, t.occupied + t.false_alarms);
  summary.iou_free.value = ratio(t.found_free, t.free + t.missed);
  summary.missed.value = ratio(t.missed, t.occupied);
  summary.false_alarms.value = ratio(t.false_alarms, t.free);
  summary.known.value = ratio(t.known, cells);
  summary.calibration_error.value = calibration_error(t);
  fill_hidden(t, summary);
  summary.depth_error_m.value = ratio(t.depth_error_m, t.columns);
  summary.depth_error_median_m.value = median(t.depth_groups, errors);
  summary.depth_bias_m.value = ratio(t.depth_bias_m, t.columns);
  summary.depth_wrong.value = ratio(t.depth_wrong, t.columns);
  summary.depth_overshoot.value = ratio(t.depth_overshoot, t.columns);
}

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
