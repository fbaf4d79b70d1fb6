// SPDX-License-Identifier: Apache-2.0
//
// Smallest lane of a vector. Included once per instruction set; the guard works per target.
#if defined(STEREOGRID_MINIMA_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_MINIMA_SIMD
#undef STEREOGRID_MINIMA_SIMD
#else
#define STEREOGRID_MINIMA_SIMD
#endif

#include <cstdint>

#include "hwy/highway.h"

#if HWY_TARGET != HWY_SCALAR
HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Block16 = hn::FixedTag<std::uint16_t, 8>;

// Minima of the blocks of 16 bytes that a vector consists of.
template <class D>
HWY_INLINE auto folded([[maybe_unused]] D d, hn::Vec<D> values) {
  if constexpr (hn::MaxLanes(D{}) * sizeof(hn::TFromD<D>) == 16) {
    return values;
  } else {
    const hn::Half<D> half;
    return folded(half, hn::Min(hn::LowerHalf(half, values), hn::UpperHalf(half, values)));
  }
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4
// Smallest number in the first lane, its first position in the second one.
HWY_INLINE hn::Vec<Block16> minimum16(hn::Vec<Block16> values) {
  return hn::Vec<Block16>{_mm_minpos_epu16(values.raw)};  // hn::MinOfLanes would broadcast the result
}
HWY_INLINE std::uint32_t minimum16_and_position(hn::Vec<Block16> values) {
  return hn::GetLane(hn::BitCast(hn::FixedTag<std::uint32_t, 4>{}, minimum16(values)));
}
#else
// Smallest number in the first lane.
HWY_INLINE hn::Vec<Block16> minimum16(hn::Vec<Block16> values) {
  return hn::MinOfLanes(Block16{}, values);
}
// Smallest number in the lower half of the result, its first position in the upper one.
HWY_INLINE std::uint32_t minimum16_and_position(hn::Vec<Block16> values) {
  const Block16 d16;
  const hn::FixedTag<std::uint32_t, 4> d32;
  const auto position = hn::Iota(d16, 0);
  const auto low = hn::BitCast(d32, hn::InterleaveLower(d16, position, values));
  const auto high = hn::BitCast(d32, hn::InterleaveUpper(d16, position, values));
  const std::uint32_t least{hn::GetLane(hn::MinOfLanes(d32, hn::Min(low, high)))};
  return least >> 16 | least << 16;
}
#endif

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // HWY_TARGET

#endif  // per-target guard
