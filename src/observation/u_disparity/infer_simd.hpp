// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace stereogrid {

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
