// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "baselines/baselines.hpp"

namespace stereogrid::research {

/// The upper one of two in the middle; `values` must not be empty.
[[nodiscard]] inline double median(std::vector<double>& values) {
  const auto middle{values.begin() + std::ssize(values) / 2};
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median of the disparities, road or obstacle, in `columns` columns and the rows first_v … last_v; 0: none.
[[nodiscard]] inline double median_disparity(const DisparityFrame& frame, int first_u, int columns, int first_v,
                                             int last_v) {
  std::vector<double> found;
  for (int v{first_v}; v <= std::min(last_v, frame.obstacle.height - 1); ++v) {
    for (int u{first_u}; u < std::min(first_u + columns, frame.obstacle.width); ++u) {
      const float d{std::max(frame.obstacle(u, v), frame.road(u, v))};
      if (d > 0) found.push_back(static_cast<double>(d));
    }
  }
  return found.empty() ? 0 : median(found);
}

}  // namespace stereogrid::research
