// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"

/// Before a loop of few rounds, whose body is not to be repeated.
#if defined(__CUDACC__)
#define STEREOGRID_ROLLED _Pragma("unroll 1")
#else
#define STEREOGRID_ROLLED
#endif

namespace stereogrid {

constexpr int warp{32};  ///< threads
constexpr unsigned whole_warp{0xffffffffU};

/// Σ over the warp, in all its lanes.
template <class Real>
__device__ inline Real sum_of_warp(Real value) {
  for (int apart{warp / 2}; apart > 0; apart /= 2) value += __shfl_xor_sync(whole_warp, value, apart);
  return value;
}

}  // namespace stereogrid
