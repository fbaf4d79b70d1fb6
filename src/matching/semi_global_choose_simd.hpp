// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// From a pixel's summed costs to its candidates: best label, runner-up, sub-pixel place. Included once per instruction
// set; the guard works per target.
#if defined(STEREOGRID_SEMI_GLOBAL_CHOOSE_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_SEMI_GLOBAL_CHOOSE_SIMD
#undef STEREOGRID_SEMI_GLOBAL_CHOOSE_SIMD
#else
#define STEREOGRID_SEMI_GLOBAL_CHOOSE_SIMD
#endif

#include <algorithm>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/semi_global_labels_simd.hpp"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

// Best of the n labels `highest`, `highest` − 1, … of pixel u; those without a cost of their own cost cost_max.
template <int n, class D>
HWY_INLINE void choose(D d8, const std::uint8_t* costs, int highest, int u, const RowChoice& choice) {
  const hn::RepartitionToWide<D> d16;
  constexpr int step{static_cast<int>(hn::MaxLanes(D{}))};
  const auto labels_at = [&](int k) {
    return hn::Sub(hn::Set(d8, static_cast<std::uint8_t>(highest - k)), hn::Iota(d8, 0));
  };
  // cost above label in 16 bits: the smallest is the cheapest, and of those the first label
  auto lowest = hn::Set(d16, 65535);
  for (int k{0}; k < n; k += step) {
    const auto cost = hn::LoadU(d8, costs + k);
    lowest = hn::Min(lowest, hn::BitCast(d16, hn::InterleaveLower(d8, labels_at(k), cost)));
    lowest = hn::Min(lowest, hn::BitCast(d16, hn::InterleaveUpper(d8, labels_at(k), cost)));
  }
  const int key{hn::GetLane(minimum16(folded(d16, lowest)))};
  const int best{key % 256};
  const int first_near{std::max(best - 1, 0)};
  const auto first = hn::Set(d8, static_cast<std::uint8_t>(first_near));
  const auto count = hn::Set(d8, static_cast<std::uint8_t>(best + 2 - first_near));
  const auto highest_cost = hn::Set(d8, static_cast<std::uint8_t>(cost_max));
  auto second = highest_cost;
  for (int k{0}; k < n; k += step) {
    const auto is_near = hn::Lt(hn::Sub(labels_at(k), first), count);
    second = hn::Min(second, hn::IfThenElse(is_near, highest_cost, hn::LoadU(d8, costs + k)));
  }
  choice.key[u] = static_cast<std::uint16_t>(key);
  choice.runner_up[u] = static_cast<std::uint8_t>(hn::GetLane(smallest_byte(d8, second)));
  choice.before[u] = costs[highest - best + 1];
  choice.after[u] = costs[highest - best - 1];
}

// subpixel_offset for a whole row.
HWY_INLINE void find_offsets(int width, int count, const RowChoice& choice) {
  const hn::CappedTag<float, 16> df;
  const hn::Rebind<std::int32_t, decltype(df)> d32;
  const hn::Rebind<std::uint8_t, decltype(df)> d8;
  const hn::Rebind<std::uint16_t, decltype(df)> d16;
  const auto zero = hn::Zero(d32);
  for (int u{0}; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto key = hn::PromoteTo(d32, hn::LoadU(d16, choice.key + u));
    const auto before = hn::PromoteTo(d32, hn::LoadU(d8, choice.before + u));
    const auto after = hn::PromoteTo(d32, hn::LoadU(d8, choice.after + u));
    const auto label = hn::And(key, hn::Set(d32, 255));
    const auto rise = hn::Sub(hn::Max(before, after), hn::ShiftRight<8>(key));
    const auto whole = hn::Div(hn::ConvertTo(df, hn::Sub(before, after)), hn::ConvertTo(df, hn::Add(rise, rise)));
    const auto offset = hn::Min(hn::Max(whole, hn::Set(df, -0.49f)), hn::Set(df, 0.49f));
    const auto inside = hn::And(hn::Gt(label, zero), hn::Lt(label, hn::Set(d32, count - 1)));
    const auto valid = hn::And(inside, hn::Gt(rise, zero));
    hn::StoreU(hn::IfThenElseZero(hn::RebindMask(df, valid), offset), df, choice.offset + u);
  }
}

// The row's candidates. Each claims the right pixel that it leads to; the cheapest claim stays, of those the smallest
// shift, and who has about its shift is consistent.
HWY_INLINE void finish(int width, Shifts shifts, int left_right_px, const RowChoice& choice, Candidate* candidates) {
  find_offsets(width, shifts.count, choice);
  std::uint16_t* const claims{choice.claims + RowChoice::reach};
  const auto right_of = [&](int u) { return u - shifts.first - choice.key[u] % 256; };
  std::fill(claims - RowChoice::reach, claims + width + RowChoice::reach, std::uint16_t{65535});
  for (int u{0}; u < width; ++u) {
    std::uint16_t& claim{claims[right_of(u)]};
    claim = std::min(claim, choice.key[u]);
  }
  for (int u{0}; u < width; ++u) {
    const int label{choice.key[u] % 256};
    const int right_u{right_of(u)};
    candidates[u].cost = choice.key[u] / 256;
    candidates[u].runner_up = choice.runner_up[u];
    candidates[u].shift = static_cast<std::int16_t>(shifts.first + label);
    candidates[u].consistent =
        right_u >= 0 && right_u < width && std::abs(claims[right_u] % 256 - label) <= left_right_px;
    candidates[u].offset = choice.offset[u];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();
#endif  // HWY_TARGET

#endif  // per-target guard
