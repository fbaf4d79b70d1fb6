// SPDX-License-Identifier: Apache-2.0
//
// From a pixel's summed costs to its candidates. Included once per instruction
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
#include "matching/semi_global/labels_simd.hpp"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

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

// The row's candidates.
HWY_INLINE void finish(int width, Shifts shifts, int uniqueness_1024, const RowChoice& choice, CandidateRow& out) {
  const hn::CappedTag<std::int32_t, 16> d32;
  const hn::Rebind<std::uint8_t, decltype(d32)> d8;
  const hn::Rebind<std::uint16_t, decltype(d32)> d16;
  const hn::Rebind<std::int16_t, decltype(d32)> signed16;
  const auto set = [&](int value) { return hn::Set(d32, value); };
  for (int u{0}; u < width; u += static_cast<int>(hn::Lanes(d32))) {
    const auto bytes_at = [&](const std::uint8_t* bytes) { return hn::PromoteTo(d32, hn::LoadU(d8, bytes + u)); };
    const auto store = [&](auto values, std::uint16_t* words) {
      hn::StoreU(hn::DemoteTo(d16, values), d16, words + u);
    };
    const auto key = hn::PromoteTo(d32, hn::LoadU(d16, choice.key + u));
    const auto cost = hn::ShiftRight<8>(key);
    const auto label = hn::And(key, set(255));
    const auto inside = hn::And(hn::Gt(label, set(0)), hn::Lt(label, set(shifts.count - 1)));
    // highest_rival
    const auto scaled = hn::Add(hn::Mul(cost, set(1024 + uniqueness_1024)), set(1023));
    const auto rival_cost = hn::Max(cost, hn::Sub(hn::ShiftRight<10>(scaled), set(1)));
    const auto is_unique = hn::Gt(bytes_at(choice.runner_up), rival_cost);
    store(cost, out.cost());
    store(hn::IfThenZeroElse(is_unique, set(1)), out.has_rivals());
    store(hn::IfThenElse(inside, bytes_at(choice.before), cost), out.before());
    store(hn::IfThenElse(inside, bytes_at(choice.after), cost), out.after());
    hn::StoreU(hn::DemoteTo(signed16, hn::Add(label, set(shifts.first))), signed16, out.shift() + u);
  }
}

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // HWY_TARGET

#endif  // per-target guard
