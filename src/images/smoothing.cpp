// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "images/smoothing.hpp"

#include <algorithm>

namespace stereogrid {

void smooth_rows(View<const std::uint8_t> image, int begin, int end, View<std::uint8_t> smoothed) {
  constexpr int chunk{256};
  std::uint16_t sums[chunk + 2];  // along the columns, from the column before the chunk on
  for (int v{begin}; v < end; ++v) {
    const std::uint8_t* const above{image.row(std::max(v - 1, 0))};
    const std::uint8_t* const row{image.row(v)};
    const std::uint8_t* const below{image.row(std::min(v + 1, image.height - 1))};
    for (int first{0}; first < image.width; first += chunk) {
      const int count{std::min(chunk, image.width - first)};
      const auto sum_at = [&](int u) { return static_cast<std::uint16_t>(above[u] + 2 * row[u] + below[u]); };
      for (int i{0}; i < count; ++i) sums[i + 1] = sum_at(first + i);
      sums[0] = sum_at(std::max(first - 1, 0));
      sums[count + 1] = sum_at(std::min(first + count, image.width - 1));
      std::uint8_t* const out{smoothed.row(v) + first};
      for (int i{0}; i < count; ++i) {
        out[i] =
            static_cast<std::uint8_t>(static_cast<std::uint16_t>(sums[i] + 2 * sums[i + 1] + sums[i + 2] + 8) >> 4);
      }
    }
  }
}

}  // namespace stereogrid
