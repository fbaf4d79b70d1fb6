// SPDX-License-Identifier: Apache-2.0
// What formulas need of vectors besides Highway's functions; numbers.hpp has the same for single numbers. Included once
// per instruction set; the guard works per target.
#if defined(STEREOGRID_NUMBERS_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_NUMBERS_SIMD
#undef STEREOGRID_NUMBERS_SIMD
#else
#define STEREOGRID_NUMBERS_SIMD
#endif

#include <cstdint>

#include "host_device.hpp"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
HWY_INLINE V number(V /*like*/, hn::TFromV<V> value) {
  return hn::Set(hn::DFromV<V>{}, value);
}
/// first, first + 1 …; hn::Iota would write them to memory one by one.
template <class D>
HWY_INLINE hn::Vec<D> numbers_from(D d, hn::TFromD<D> first) {
  return hn::Add(hn::Iota(d, 0), hn::Set(d, first));
}
template <class V>
HWY_INLINE auto real(V values) {
  return hn::ConvertTo(hn::Rebind<float, hn::DFromV<V>>{}, values);
}
// Assumes values within the integers' range; hn::ConvertTo spends five instructions on others.
template <class V>
HWY_INLINE auto whole(V values) {
  using Ints = hn::Rebind<std::int32_t, hn::DFromV<V>>;
#if HWY_TARGET == HWY_AVX2
  if constexpr (sizeof(V) == 32) return hn::Vec<Ints>{_mm256_cvttps_epi32(values.raw)};
#endif
  return hn::ConvertTo(Ints{}, values);
}
template <class V, class M>
HWY_INLINE auto condition(V /*like*/, M values) {
  return hn::RebindMask(hn::DFromV<V>{}, values);
}
template <class V>
HWY_INLINE V less_half_of_bits(std::uint32_t from, V x) {
  const hn::Rebind<std::uint32_t, hn::DFromV<V>> bits;
  return hn::BitCast(hn::DFromV<V>{}, hn::Sub(hn::Set(bits, from), hn::ShiftRight<1>(hn::BitCast(bits, x))));
}

template <class V>
HWY_INLINE auto exponent_of(V x) {
  const hn::Rebind<std::int32_t, hn::DFromV<V>> ints;
  const auto bits = hn::BitCast(ints, x);
  const auto is_above = hn::And(hn::ShiftRight<22>(bits), hn::Set(ints, 1));
  return hn::Sub(hn::Add(hn::ShiftRight<23>(bits), is_above), hn::Set(ints, 127));
}
template <class V, class Ints>
HWY_INLINE V mantissa_of(V x, Ints exponent) {
  return hn::BitCast(hn::DFromV<V>{}, hn::Sub(hn::BitCast(hn::DFromV<Ints>{}, x), hn::ShiftLeft<23>(exponent)));
}
template <class V>
HWY_INLINE V power_of_two(V exponent) {
  const hn::DFromV<V> d;
  const hn::Rebind<std::int32_t, decltype(d)> ints;
  return hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(whole(exponent), hn::Set(ints, 127))));
}

#include "number_formulas.hpp"

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
