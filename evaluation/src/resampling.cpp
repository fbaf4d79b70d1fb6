// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "resampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stereogrid::evaluation {

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
