// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"

namespace stereogrid {

constexpr int warp{32};  ///< threads
constexpr unsigned whole_warp{0xffffffffU};

/// Σ over the warp, in all its lanes.
template <class Real>
__device__ inline Real sum_of_warp(Real value) {
  for (int apart{warp / 2}; apart > 0; apart /= 2) value += __shfl_xor_sync(whole_warp, value, apart);
  return value;
}

/// Σ over the warp of as many numbers of each lane as a power of 2: lane l is given that of number l % count. With each
/// step a lane hands half of its sums to another.
template <int count>
__device__ inline float sums_of_warp(float (&sums)[count]) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  for (int half{count / 2}; half > 0; half /= 2) {
    const bool is_upper{(lane & half) != 0};
    for (int i{0}; i < half; ++i) {
      const float given{__shfl_xor_sync(whole_warp, is_upper ? sums[i] : sums[i + half], half)};
      sums[i] = (is_upper ? sums[i + half] : sums[i]) + given;
    }
  }
  for (int apart{count}; apart < warp; apart *= 2) sums[0] += __shfl_xor_sync(whole_warp, sums[0], apart);
  return sums[0];
}

}  // namespace stereogrid
