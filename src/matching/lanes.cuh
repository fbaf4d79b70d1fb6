// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "matching/cuda.hpp"

/// Before a loop over an array that is to stay in registers.
#if defined(__CUDACC__)
#define STEREOGRID_UNROLL _Pragma("unroll")
#else
#define STEREOGRID_UNROLL
#endif

namespace stereogrid {

constexpr unsigned all_lanes{0xffffffffu};

__device__ inline int clamped(int value, int count) {
  return min(max(value, 0), count - 1);
}

/// Costs of a pixel's labels, spread over a group of `lanes` lanes: word i of lane l has labels 4(l + i·lanes) and the
/// three after it, the first and third in `even`, the others in `odd`, 16 bits each.
template <int words>
struct LaneCosts {
  std::uint32_t even[words];
  std::uint32_t odd[words];
};

/// Four bytes as even and odd halves of a word of LaneCosts.
__device__ inline std::uint32_t even_bytes(std::uint32_t bytes) {
  return bytes & 0x00ff00ffu;
}
__device__ inline std::uint32_t odd_bytes(std::uint32_t bytes) {
  return bytes >> 8 & 0x00ff00ffu;
}

/// The smallest value of a group of lanes, in all of them.
template <int lanes>
__device__ inline unsigned least_of_lanes(unsigned value) {
  for (int offset{lanes / 2}; offset > 0; offset /= 2) {
    value = min(value, __shfl_xor_sync(all_lanes, value, offset, lanes));
  }
  return value;
}
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
template <>
__device__ inline unsigned least_of_lanes<32>(unsigned value) {
  return __reduce_min_sync(all_lanes, value);
}
#endif

/// Bits that are set in any lane's word.
__device__ inline std::uint32_t any_of_lanes(std::uint32_t word) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
  return __reduce_or_sync(all_lanes, word);
#else
  for (int offset{16}; offset > 0; offset /= 2) word |= __shfl_xor_sync(all_lanes, word, offset);
  return word;
#endif
}

/// The search for the best of up to `count` labels. All lanes of the warp take part, each group for a pixel of its own.
template <int lanes, int words>
class BestLabel {
 public:
  __device__ BestLabel(int count, int uniqueness_1024)
      : lane_{static_cast<int>(threadIdx.x) % lanes}, count_{count}, uniqueness_1024_{uniqueness_1024} {}

  /// The same in all lanes of the group.
  __device__ FoundLabel find(const LaneCosts<words>& costs) const {
    unsigned least{all_lanes};
    for (int i{0}; i < words; ++i) {
      for (int k{0}; k < 4; ++k) least = min(least, key(costs, i, k));
    }
    least = least_of_lanes<lanes>(least);
    const int best{static_cast<int>(least & 255u)};
    const int cost{static_cast<int>(least >> 8)};
    const bool inside{best > 0 && best < count_ - 1};
    return {static_cast<std::uint16_t>(cost), cost_of(costs, inside ? best - 1 : best),
            cost_of(costs, inside ? best + 1 : best), static_cast<std::uint8_t>(best),
            static_cast<std::uint8_t>(has_rivals(costs, best, cost) ? 1 : 0)};
  }

 private:
  __device__ int first_label(int i) const { return 4 * (lane_ + i * lanes); }

  // Cost · 256 + label, so that the first of the cheapest is the least; beyond all others where there is no such label.
  __device__ unsigned key(const LaneCosts<words>& costs, int i, int k) const {
    const int label{first_label(i) + k};
    const unsigned tag{static_cast<unsigned>(label < count_ ? label : 0xff00 | (label & 0xff))};
    return __byte_perm(k % 2 == 0 ? costs.even[i] : costs.odd[i], tag, k < 2 ? 0x5104 : 0x5324);
  }

  // Cost of any label, read by the whole group.
  __device__ std::uint16_t cost_of(const LaneCosts<words>& costs, int label) const {
    const int word{label / 4};
    std::uint32_t both{0};
    for (int i{0}; i < words; ++i) {
      if (i == word / lanes) both = label % 2 == 0 ? costs.even[i] : costs.odd[i];
    }
    both = __shfl_sync(all_lanes, both, word % lanes, lanes);
    return static_cast<std::uint16_t>(label % 4 < 2 ? both & 0xffffu : both >> 16);
  }

  __device__ bool has_rivals(const LaneCosts<words>& costs, int best, int cost) const {
    const int limit{highest_rival(cost, uniqueness_1024_)};
    const unsigned largest_key{static_cast<unsigned>(limit) << 8 | 255u};
    bool has_one{false};
    for (int i{0}; i < words; ++i) {
      for (int k{0}; k < 4; ++k) {
        const bool is_far{static_cast<unsigned>(first_label(i) + k - best + 1) > 2u};
        has_one = has_one || (is_far && key(costs, i, k) <= largest_key);
      }
    }
    const unsigned lanes_with_one{__ballot_sync(all_lanes, has_one ? 1 : 0)};
    const int first_lane{static_cast<int>(threadIdx.x) % 32 / lanes * lanes};
    return (lanes_with_one >> first_lane & (all_lanes >> (32 - lanes))) != 0;
  }

  int lane_;
  int count_;
  int uniqueness_1024_;
};

}  // namespace stereogrid
