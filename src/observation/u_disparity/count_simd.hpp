// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "observation/u_disparity/rows.hpp"

namespace stereogrid {

/// Contribution of a pixel to a bin. A pixel is counted once, in the bin at which its ray arrives.
enum PixelKind {
  upright_pixel,     ///< its ray ends here at an obstacle
  passing_pixel,     ///< an obstacle too low, or nearer than all bins of its row
  road_pixel,        ///< its ray ends here at the road
  early_road_pixel,  ///< … at the road in the bin before, which its row is not possible for
  road_mark,         ///< road without a ray
  leaving_pixels,    ///< not one pixel: all rays of a row that is not possible from this bin on
  pixel_kinds
};

/// Columns of a block. `counts` of a block are [bins + 1][pixel_kinds][block_columns]; they are all 0 between frames.
constexpr int block_columns{64};

/// Columns with the same shift of rows, and all rows of them.
struct PixelBlock {
  const float* obstacle;
  const float* road;
  std::ptrdiff_t stride;  ///< stride of both
  int width;              ///< ≤ block_columns
  int height;
  int disparities;
  bool road_rays;
  const BinRange* bins;     ///< [row]
  const BinRange* upright;  ///< [row]
};

void count_pixels(const PixelBlock& block, std::uint16_t* counts);

/// Output of a block, N_V, N_O and the road's bins: pointers to bin 0 of its first column.
struct BlockTotals {
  std::uint16_t* visible;
  std::uint16_t* observed;
  std::uint8_t* has_road;
  std::ptrdiff_t stride;  ///< stride of the three
  int width;
  int disparities;
};

/// Adds a block's counts up, nearer bins first, and leaves them 0.
void total_block(const BlockTotals& totals, std::uint16_t* counts);

}  // namespace stereogrid
