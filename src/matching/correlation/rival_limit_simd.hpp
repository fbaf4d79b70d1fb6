// SPDX-License-Identifier: Apache-2.0
//
// Vectors of both hypotheses, and their test for uniqueness. Included once per instruction set; the guard works per
// target.
#if defined(STEREOGRID_RIVAL_LIMIT_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_RIVAL_LIMIT_SIMD
#undef STEREOGRID_RIVAL_LIMIT_SIMD
#else
#define STEREOGRID_RIVAL_LIMIT_SIMD
#endif

#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::ScalableTag<std::uint8_t>;
using Words = hn::ScalableTag<std::uint16_t>;
using V8 = hn::Vec<Bytes>;
using V16 = hn::Vec<Words>;

// highest_rival + 1.
HWY_INLINE V16 rival_limit(V16 cost, int uniqueness_1024) {
  const Words d16;
  const auto set = [&](int value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); };
  // ⌈cost · uniqueness / 1024⌉ above the cost
  const auto share_high = hn::MulHigh(cost, set(uniqueness_1024));
  const auto share_low = hn::Mul(cost, set(uniqueness_1024));
  const auto rest = hn::Min(hn::And(share_low, set(1023)), set(1));
  const auto share = hn::Add(hn::Add(hn::ShiftLeft<6>(share_high), hn::ShiftRight<10>(share_low)), rest);
  return hn::Add(cost, hn::Max(share, set(1)));
}

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
