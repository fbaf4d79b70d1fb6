// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/medians.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "geometry/relief.hpp"

namespace stereogrid::plain {

void find_medians(View<const float> obstacle, View<const float> road, int column, RowRange rows, float* medians) {
  for (int v{rows.begin}; v < rows.end; ++v) {
    std::array<float, sector_px> found{};
    std::size_t count{0};
    for (int u{column}; u < std::min(column + sector_px, obstacle.width); ++u) {
      const float disparity{std::max(obstacle(u, v), road(u, v))};
      if (!(disparity > 0)) continue;
      std::size_t place{count++};
      for (; place > 0 && found[place - 1] > disparity; --place) found[place] = found[place - 1];
      found[place] = disparity;
    }
    *medians++ = count < 3 ? 0.0f : found[count / 2];
  }
}

}  // namespace stereogrid::plain
