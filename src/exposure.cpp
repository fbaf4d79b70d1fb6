// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numeric>

namespace stereogrid {
namespace {

constexpr int saturated_grey{250};
constexpr int black_grey{5};

int sum_of(const GreyCounts& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0);
}

double saturated_share(const GreyCounts& counts) {
  const int all{std::max(sum_of(counts), 1)};
  return static_cast<double>(std::accumulate(counts.begin() + saturated_grey, counts.end(), 0)) / all;
}

/// Grey level below which the share `rank` of the pixels lies.
int quantile(const GreyCounts& counts, double rank) {
  const double wanted{rank * sum_of(counts)};
  int below{0};
  for (std::size_t grey{0}; grey < counts.size(); ++grey) {
    below += counts[grey];
    if (below > wanted) return static_cast<int>(grey);
  }
  return static_cast<int>(counts.size()) - 1;
}

double mean_of(const GreyCounts& counts) {
  double sum{0};
  for (std::size_t grey{0}; grey < counts.size(); ++grey) sum += static_cast<double>(grey) * counts[grey];
  return sum / std::max(sum_of(counts), 1);
}

bool is_exposed(int grey) {
  return grey > black_grey && grey < saturated_grey;
}

}  // namespace

GreyTransfer transfer_of(const GreyCounts& from, const GreyCounts& to) {
  GreyTransfer transfer{};
  const double scale{static_cast<double>(sum_of(to)) / std::max(sum_of(from), 1)};
  double below_from{0};
  double below_to{0};
  std::size_t grey{0};
  for (std::size_t i{0}; i < transfer.size(); ++i) {
    const double rank{scale * (below_from + 0.5 * from[i])};
    below_from += from[i];
    while (grey + 1 < to.size() && below_to + to[grey] <= rank) below_to += to[grey++];
    transfer[i] = static_cast<std::uint8_t>(grey);
  }
  return transfer;
}

Exposure exposure_of(const GreyCounts& left, const GreyCounts& right) {
  constexpr int ranks{20};
  std::array<double, ranks> gains{};
  std::size_t count{0};
  for (int k{1}; k < ranks; ++k) {
    const double rank{static_cast<double>(k) / ranks};
    const int l{quantile(left, rank)};
    const int r{quantile(right, rank)};
    if (is_exposed(l) && is_exposed(r)) gains[count++] = static_cast<double>(r) / l;
  }
  Exposure exposure{1, saturated_share(left), saturated_share(right)};
  if (count > 0) {
    const auto middle{gains.begin() + static_cast<std::ptrdiff_t>(count / 2)};
    std::nth_element(gains.begin(), middle, gains.begin() + static_cast<std::ptrdiff_t>(count));
    exposure.gain = *middle;
  } else {
    exposure.gain = std::max(mean_of(right), 1.0) / std::max(mean_of(left), 1.0);
  }
  return exposure;
}

bool is_unequal(const Exposure& exposure) {
  // Feature tracking rejects patches of which a fifth of the variance is left: a gain of 1.45.
  constexpr double gain_max{1.45};
  constexpr double gain_covered{6};  // a lens that is covered or a camera that is off, not an exposure
  constexpr double gain_max_saturated{1.2};
  constexpr double more_saturated_max{0.05};
  const bool is_right{exposure.gain > 1};
  const double gain{is_right ? exposure.gain : 1 / exposure.gain};
  const double more_saturated{is_right ? exposure.right_saturated - exposure.left_saturated
                                       : exposure.left_saturated - exposure.right_saturated};
  if (gain > gain_covered) return false;
  return gain > gain_max || (gain > gain_max_saturated && more_saturated > more_saturated_max);
}

std::string text_of(const Exposure& exposure) {
  constexpr double saturated_min{0.025};
  constexpr double percent_step{5};
  const bool is_right{exposure.gain > 1};
  const double saturated{is_right ? exposure.right_saturated : exposure.left_saturated};
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "the %s image is %.1f × brighter than the %s", is_right ? "right" : "left",
                is_right ? exposure.gain : 1 / exposure.gain, is_right ? "left" : "right");
  std::string sentence{text.data()};
  if (saturated > saturated_min) {
    const double percent{std::round(100 * saturated / percent_step) * percent_step};
    std::snprintf(text.data(), text.size(), " and %.0f %% of it is saturated", percent);
    sentence += text.data();
  }
  return sentence + ": " + std::string{exposure_remedy} + ".";
}

}  // namespace stereogrid
