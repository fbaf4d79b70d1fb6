// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/correlation/census_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                    // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/correlation/simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

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

using Columns = hn::CappedTag<std::int32_t, 16>;

// Disparities of the road at columns, in 1/256 px.
HWY_INLINE hn::Vec<Columns> road_disparity(hn::Vec<Columns> column, const RoadRow& road) {
  const auto set = [&](std::int32_t value) { return hn::Set(Columns{}, value); };
  const auto tilt = hn::ShiftRight<2>(hn::Add(hn::Mul(column, set(road.slope)), set(2)));
  return hn::ShiftRight<8>(hn::Add(tilt, set(road.start + 128)));
}

// At the row's ends, and where the road's tilt adds up to a pixel.
void shear_apart(const std::uint8_t* right_row, int width, const RoadRow& road, int u, std::uint8_t* out) {
  const Columns d32;
  const auto set = [&](std::int32_t value) { return hn::Set(d32, value); };
  const auto column = hn::Add(hn::Iota(d32, 0), set(u));
  const auto position = hn::Sub(hn::ShiftLeft<8>(column), road_disparity(column, road));
  const auto below = hn::Min(hn::Max(hn::ShiftRight<8>(position), set(-1)), set(width - 1));
  // four pixels from `below` on, of which two are used
  const auto pixels = hn::GatherOffset(d32, reinterpret_cast<const std::int32_t*>(right_row), below);
  const auto a = hn::And(pixels, set(255));
  const auto b = hn::And(hn::ShiftRight<8>(pixels), set(255));
  const auto sum = hn::Add(hn::ShiftLeft<8>(a), hn::Mul(hn::Sub(b, a), hn::And(position, set(255))));
  const auto grey = hn::ShiftRight<8>(hn::Add(sum, set(128)));
  const hn::Rebind<std::uint8_t, Columns> d8;
  hn::StoreU(hn::DemoteTo(d8, grey), d8, out + u);
}

#if HWY_TARGET != HWY_SCALAR
// Two vectors of columns whose pixels lie side by side from right_row[first] on.
HWY_INLINE void shear_evenly(const std::uint8_t* right_row, int first, const RoadRow& road, int u, std::uint8_t* out) {
  const Columns d32;
  const hn::Repartition<std::uint16_t, Columns> d16;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const auto set = [&](int value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); };
  const auto disparity = [&](int at) {
    return hn::BitCast(d16, road_disparity(hn::Add(hn::Iota(d32, 0), hn::Set(d32, at)), road));
  };
  const auto low = disparity(u);
  const auto high = disparity(u + static_cast<int>(hn::Lanes(d32)));
  const auto part = hn::And(hn::Sub(set(0), hn::ConcatEven(d16, high, low)), set(255));
  const auto a = hn::PromoteTo(d16, hn::LoadU(d8, right_row + first));
  const auto b = hn::PromoteTo(d16, hn::LoadU(d8, right_row + first + 1));
  // below 65536, though the product may not be
  const auto sum = hn::Add(hn::Add(hn::ShiftLeft<8>(a), set(128)), hn::Mul(hn::Sub(b, a), part));
  const hn::Rebind<std::int16_t, decltype(d16)> signed16;
  hn::StoreU(hn::DemoteTo(d8, hn::BitCast(signed16, hn::ShiftRight<8>(sum))), d8, out + u);
}
#endif

void ShearRow(const std::uint8_t* right_row, int width, const RoadRow& road, std::uint8_t* out) {
  const int lanes{static_cast<int>(hn::Lanes(Columns{}))};
  for (int u{0}; u < width; u += 2 * lanes) {
#if HWY_TARGET != HWY_SCALAR
    const auto pixel_below = [&](int at) { return (at * 256 - ((road.at(at) + 128) >> 8)) >> 8; };
    const int first{pixel_below(u)};
    const int last{pixel_below(u + 2 * lanes - 1)};
    if (last - first == 2 * lanes - 1 && first >= -1 && last < width) {
      shear_evenly(right_row, first, road, u, out);
      continue;
    }
#endif
    shear_apart(right_row, width, road, u, out);
    shear_apart(right_row, width, road, u + lanes, out);
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(ShortCensusRow);
HWY_EXPORT(ShortCensusReversed);
HWY_EXPORT(ShearRow);

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
