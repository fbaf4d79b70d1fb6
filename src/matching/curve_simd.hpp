// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// A pixel's cost curve with vectors, for every matcher: filling it and reading it. Included
// once per instruction set by *_simd.cpp; the guard works per target.
#if defined(STEREOGRID_CURVE_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_CURVE_SIMD
#undef STEREOGRID_CURVE_SIMD
#else
#define STEREOGRID_CURVE_SIMD
#endif

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "hwy/highway.h"
#include "matching/matching.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Order of right pixels from right to left, borders repeated: the shifts of a left pixel then lie in a row.
class RightToLeft {
 public:
  RightToLeft(int width, Shifts shifts) : width_{width}, first_{shifts.first}, offset_{std::max(0, -shifts.first)} {}

  // Place of the right pixel that belongs to u and the first shift.
  [[nodiscard]] int start(int u) const { return width_ - 1 - u + first_ + offset_; }
  // Places that are used when every left pixel has n shifts.
  [[nodiscard]] int length(int n) const { return start(0) + n; }

  void reverse(const std::uint32_t* row, int n, std::uint32_t* out) const {
    for (int j{0}; j < length(n); ++j) out[j] = row[std::clamp(width_ - 1 + offset_ - j, 0, width_ - 1)];
  }

 private:
  int width_;
  int first_;
  int offset_;
};

// Costs of one pixel: bits in which its descriptor differs from each of n right ones; n is a multiple of 16.
inline void hamming(std::uint32_t left, const std::uint32_t* right, int n, std::uint8_t* out) {
  const hn::CappedTag<std::uint32_t, 16> d32;
  const hn::Rebind<std::uint8_t, decltype(d32)> d8;
  const int lanes{static_cast<int>(hn::Lanes(d32))};
  const auto descriptor = hn::Set(d32, left);
  for (int k{0}; k < n; k += lanes) {
    const auto differing = hn::PopulationCount(hn::Xor(descriptor, hn::LoadU(d32, right + k)));
    hn::StoreU(hn::U8FromU32(differing), d8, out + k);
  }
}

// In what follows, `d16` is a tag for vectors of uint16 whose length divides n, the padded number of shifts.

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
Candidate candidate_of(D16 d16, std::uint16_t* costs, Shifts shifts, int uniqueness_1024, int n) {
  const int count{shifts.count};
  if (count < n) std::fill(costs + count, costs + n, std::uint16_t{65535});
  const std::uint16_t cost{minimum(d16, costs, n)};
  const int best{first_of(d16, costs, cost, n)};
  const bool inside{best > 0 && best < count - 1};
  const bool is_unique{runner_up_of(d16, costs, best, n) > highest_rival(cost, uniqueness_1024)};
  return {cost, static_cast<std::uint16_t>(is_unique ? 0 : 1), inside ? costs[best - 1] : cost,
          inside ? costs[best + 1] : cost, static_cast<std::int16_t>(shifts.first + best)};
}

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
