// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "geometry/relief.hpp"
#include "obstacles/segmentation/segments.hpp"
#include "obstacles/segmentation/upright_row.hpp"

namespace stereogrid {

/// Obstacle pixels of a row and their bins of the u-disparity plane.
struct BinnedPixels : UprightPixels {
  std::array<int, most> bins;
  std::array<int, most> counts;  ///< 1 below the height of obstacles, else 0
};

/// On the plane. The compiler turns the loop into vectors.
inline void classify(const UprightRow& row, BinnedPixels& pixels) {
  const UprightRow limits{row};
  for (int i{0}; i < pixels.size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    pixels.bins[k] = static_cast<int>(pixels.disparities[i] * Segmenter::bins_per_px);
    pixels.counts[k] = static_cast<int>(limits.is_below_highest(pixels.columns[i], pixels.disparities[i]));
  }
}

/// Keeps the pixels that are upright on the local ground.
inline void classify(const UprightRow& row, float road_per_row_px, const Relief<Host>& relief, BinnedPixels& pixels) {
  std::size_t size{0};
  for (int i{0}; i < pixels.size; ++i) {
    const int column{pixels.columns[i]};
    const float disparity{pixels.disparities[i]};
    UprightRow local{row};
    local.road_px += road_per_row_px * static_cast<float>(relief.rows_at(column, disparity));
    pixels.columns[size] = column;
    pixels.bins[size] = static_cast<int>(disparity * Segmenter::bins_per_px);
    pixels.counts[size] = static_cast<int>(local.is_below_highest(column, disparity));
    size += local.is_upright(column, disparity) ? 1 : 0;
  }
  pixels.size = static_cast<int>(size);
}

}  // namespace stereogrid
