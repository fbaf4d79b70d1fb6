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

/// Input and output of the probabilities of the bins (0 … width−1, d).
struct BinRow {
  const std::uint16_t* visible;     ///< N_V
  const std::uint16_t* observed;    ///< N_O
  const std::uint8_t* road_before;  ///< bins with a road pixel among u−1, u, u+1, at d−1
  const std::uint8_t* road_here;    ///< … at d
  const std::uint8_t* road_behind;  ///< … at d+1
  const std::int32_t* shift;        ///< shift of the columns, in rows
  int first_row;                    ///< first row of the bin in the column u0; the image may end before
  int last_row;
  int image_height;
  const float* miss;         ///< [pair_index(N_V, N_O)]
  const float* road_factor;  ///< [road cells among 9]
  float false_positive;
  float false_negative;
  int first_sighted;  ///< columns before it stay unknown
  float* visibility;
  float* obstacle_confidence;
  float* road_confidence;
  float* occupancy;
};

/// Equations 8 and 11 to 15 for a row of bins.
void infer_bins(const BinRow& row, int width);

/// out[u] = Σ_k weights[k]·in[k][u], k from 0 to count − 1 in this order.
void weigh_rows(const float* const* in, const float* weights, int count, int width, float* out);

}  // namespace stereogrid
