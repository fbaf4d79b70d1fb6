// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Reading a pixel's cost curve with vectors. Included once per instruction set by *_simd.cpp; the guard works per
// target.
#if defined(STEREOGRID_CURVE_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_CURVE_SIMD
#undef STEREOGRID_CURVE_SIMD
#else
#define STEREOGRID_CURVE_SIMD
#endif

#include <algorithm>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/matching.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// In all of these, `d16` is a tag for vectors of uint16 whose length divides n, the padded number of shifts.

template <class D16>
std::uint16_t minimum(D16 d16, const std::uint16_t* costs, int n) {
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  auto smallest = hn::LoadU(d16, costs);
  for (int k{lanes}; k < n; k += lanes) smallest = hn::Min(smallest, hn::LoadU(d16, costs + k));
  return hn::GetLane(hn::MinOfLanes(d16, smallest));
}

template <class D16>
int first_of(D16 d16, const std::uint16_t* costs, std::uint16_t value, int n) {
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  const auto wanted = hn::Set(d16, value);
  for (int k{0}; k < n; k += lanes) {
    const auto found = hn::FindFirstTrue(d16, hn::Eq(hn::LoadU(d16, costs + k), wanted));
    if (found >= 0) return k + static_cast<int>(found);
  }
  return 0;
}

// Smallest cost more than one step away from `best`.
template <class D16>
std::uint16_t runner_up_of(D16 d16, const std::uint16_t* costs, int best, int n) {
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  const auto highest = hn::Set(d16, std::uint16_t{65535});
  auto smallest = highest;
  for (int k{0}; k < n; k += lanes) {
    // wraps round for shifts before best − 1
    const auto distance = hn::Iota(d16, static_cast<std::uint16_t>(k - best + 1));
    const auto is_near = hn::Lt(distance, hn::Set(d16, std::uint16_t{3}));
    smallest = hn::Min(smallest, hn::IfThenElse(is_near, highest, hn::LoadU(d16, costs + k)));
  }
  return hn::GetLane(hn::MinOfLanes(d16, smallest));
}

// Costs beyond the last shift must never win; they are set anew for each pixel.
template <class D16>
Candidate candidate_of(D16 d16, std::uint16_t* costs, Shifts shifts, int n) {
  const int count{shifts.count};
  if (count < n) std::fill(costs + count, costs + n, std::uint16_t{65535});
  const std::uint16_t cost{minimum(d16, costs, n)};
  const int best{first_of(d16, costs, cost, n)};
  const bool inside{best > 0 && best < count - 1};
  return {cost, runner_up_of(d16, costs, best, n), static_cast<std::int16_t>(shifts.first + best), false,
          inside ? subpixel_offset(costs[best - 1], cost, costs[best + 1]) : 0.0f};
}

// Lets the shifts of a left pixel compete for the right pixels that they lead to: both arrays begin at the right pixel
// of the first shift and run from right to left.
template <class D16>
void offer_to_right(D16 d16, const std::uint16_t* costs, std::uint16_t* right_cost, std::uint16_t* right_best, int n) {
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  for (int k{0}; k < n; k += lanes) {
    const auto cost = hn::LoadU(d16, costs + k);
    const auto smallest = hn::LoadU(d16, right_cost + k);
    const auto better = hn::Lt(cost, smallest);
    const auto shift = hn::Iota(d16, static_cast<std::uint16_t>(k));
    hn::StoreU(hn::IfThenElse(better, shift, hn::LoadU(d16, right_best + k)), d16, right_best + k);
    hn::StoreU(hn::Min(cost, smallest), d16, right_cost + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
