// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/correlation/census_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                    // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/correlation/census_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

void CensusRow(const std::uint8_t* const* window, int width, std::uint32_t* out) {
  const hn::ScalableTag<std::uint8_t> d8;
  const int lanes{static_cast<int>(hn::Lanes(d8))};
  const auto one = hn::Set(d8, std::uint8_t{1});
  for (int u{0}; u < width; u += lanes) {
    // the descriptor's four bytes, most significant first; comparisons come in the order of `census`
    auto bytes_0 = hn::Zero(d8);
    auto bytes_1 = hn::Zero(d8);
    auto bytes_2 = hn::Zero(d8);
    auto bytes_3 = hn::Zero(d8);
    int bit{census_bits};
    for (int j{-census_half_v}; j <= 0; ++j) {
      const int last{j < 0 ? census_half_u : -1};
      for (int i{-census_half_u}; i <= last; ++i) {
        const auto pixel = hn::LoadU(d8, window[census_half_v + j] + u + i);
        const auto mirrored = hn::LoadU(d8, window[census_half_v - j] + u - i);
        const auto is_darker = hn::IfThenElseZero(hn::Lt(pixel, mirrored), one);
        --bit;
        auto& bytes = bit >= 24 ? bytes_3 : (bit >= 16 ? bytes_2 : (bit >= 8 ? bytes_1 : bytes_0));
        bytes = hn::Or(hn::Add(bytes, bytes), is_darker);
      }
    }
    hn::StoreInterleaved4(bytes_0, bytes_1, bytes_2, bytes_3, d8, reinterpret_cast<std::uint8_t*>(out + u));
  }
}

// store(descriptors, u)
template <class Store>
HWY_INLINE void short_census_of(const std::uint8_t* const* window, int width, int bits, const Store& store) {
  const hn::ScalableTag<std::uint8_t> d8;
  const int lanes{static_cast<int>(hn::Lanes(d8))};
  const auto compared = hn::Set(d8, static_cast<std::uint8_t>((1 << bits) - 1));
  for (int u{0}; u < width; u += lanes) {
    const auto darker = [&](int i, int j, int bit) {
      const auto pixel = hn::LoadU(d8, window[short_census_half_v + j] + u + i);
      const auto mirrored = hn::LoadU(d8, window[short_census_half_v - j] + u - i);
      return hn::IfThenElseZero(hn::Lt(pixel, mirrored), hn::Set(d8, static_cast<std::uint8_t>(1 << bit)));
    };
    const auto near = hn::Or(hn::Or(darker(-1, 0, 0), darker(-2, 0, 1)), hn::Or(darker(-1, -1, 2), darker(1, -1, 3)));
    const auto far = hn::Or(hn::Or(darker(-3, -1, 4), darker(3, -1, 5)), hn::Or(darker(-2, -2, 6), darker(2, -2, 7)));
    store(hn::And(hn::Or(near, far), compared), u);
  }
}

void ShortCensusRow(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out) {
  const hn::ScalableTag<std::uint8_t> d8;
  short_census_of(window, width, bits, [&](auto bytes, int u) { hn::StoreU(bytes, d8, out + u); });
}

void ShortCensusReversed(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out) {
  const hn::ScalableTag<std::uint8_t> d8;
  short_census_of(window, width, bits, [&](auto bytes, int u) {
    std::uint8_t* const to{out + width - u - static_cast<int>(hn::Lanes(d8))};
    if constexpr (hn::MaxLanes(hn::ScalableTag<std::uint8_t>{}) == 1) {
      hn::StoreU(bytes, d8, to);
    } else {
      const hn::Repartition<std::uint16_t, decltype(d8)> d16;
      const auto pairs = hn::Reverse(d16, hn::BitCast(d16, bytes));
      hn::StoreU(hn::BitCast(d8, hn::Or(hn::ShiftLeft<8>(pairs), hn::ShiftRight<8>(pairs))), d8, to);
    }
  });
}

void ShearRow(const std::uint8_t* right_row, int width, const RoadRow& road, std::uint8_t* out) {
  const hn::CappedTag<std::int32_t, 16> d32;
  const hn::Rebind<std::uint8_t, decltype(d32)> d8;
  const int lanes{static_cast<int>(hn::Lanes(d32))};
  const auto set = [&](std::int32_t value) { return hn::Set(d32, value); };
  const auto pixel_below = [&](int u) { return (u * 256 - ((road.at(u) + 128) >> 8)) >> 8; };
  auto column = hn::Iota(d32, 0);
  auto tilt = hn::Add(hn::Mul(column, set(road.slope)), set(2));
  for (int u{0}; u < width; u += lanes) {
    const auto disparity = hn::ShiftRight<8>(hn::Add(hn::ShiftRight<2>(tilt), set(road.start + 128)));
    const auto position = hn::Sub(hn::ShiftLeft<8>(column), disparity);
    const auto part = hn::And(position, set(255));
    const int first{pixel_below(u)};
    auto a = hn::Zero(d32);
    auto b = hn::Zero(d32);
    const int last{pixel_below(u + lanes - 1)};
    if (last - first == lanes - 1 && first >= -1 && last < width) {
      a = hn::PromoteTo(d32, hn::LoadU(d8, right_row + first));
      b = hn::PromoteTo(d32, hn::LoadU(d8, right_row + first + 1));
    } else {  // at the ends, and where the road's tilt adds up to a pixel
      const auto below = hn::Min(hn::Max(hn::ShiftRight<8>(position), set(-1)), set(width - 1));
      // four pixels from `below` on, of which two are used
      const auto pixels = hn::GatherOffset(d32, reinterpret_cast<const std::int32_t*>(right_row), below);
      a = hn::And(pixels, set(255));
      b = hn::And(hn::ShiftRight<8>(pixels), set(255));
    }
    const auto sum = hn::Add(hn::ShiftLeft<8>(a), hn::Mul(hn::Sub(b, a), part));
    hn::StoreU(hn::DemoteTo(d8, hn::ShiftRight<8>(hn::Add(sum, set(128)))), d8, out + u);
    column = hn::Add(column, set(lanes));
    tilt = hn::Add(tilt, set(lanes * road.slope));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(CensusRow);
HWY_EXPORT(ShortCensusRow);
HWY_EXPORT(ShortCensusReversed);
HWY_EXPORT(ShearRow);

void census_row(const std::uint8_t* const* window, int width, std::uint32_t* out) {
  HWY_DYNAMIC_DISPATCH(CensusRow)(window, width, out);
}

void short_census_row(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ShortCensusRow)(window, width, bits, out);
}

void short_census_reversed(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ShortCensusReversed)(window, width, bits, out);
}

void shear_row(const std::uint8_t* right_row, int width, const RoadRow& road, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ShearRow)(right_row, width, road, out);
}

}  // namespace stereogrid
#endif
