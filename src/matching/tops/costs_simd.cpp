// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the disparities.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/tops/costs_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                            // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/correlation/simd.hpp"
#include "matching/tops/tops.hpp"
#if HWY_TARGET != HWY_SCALAR
#include "matching/correlation/differing_bits_simd.hpp"
#include "matching/minima_simd.hpp"
#endif

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#if HWY_TARGET != HWY_SCALAR

// The first of the least costs; 0 where all exceed the limit.
HWY_INLINE std::uint8_t Cheapest(const std::uint8_t* costs, std::ptrdiff_t pitch, int limit) {
  const Bytes d8;
  const Words d16;
  auto vector = hn::Load(d8, costs);
  for (std::ptrdiff_t k{bytes_of_vector}; k < pitch; k += bytes_of_vector) {
    vector = hn::Min(vector, hn::Load(d8, costs + k));
  }
  const auto pairs = hn::BitCast(d16, vector);
  const auto of_pairs = hn::Min(hn::And(pairs, hn::Set(d16, std::uint16_t{255})), hn::ShiftRight<8>(pairs));
  const int least{hn::ExtractLane(minimum16(folded(d16, of_pairs)), 0)};
  if (least > limit) return 0;
  const auto leasts = hn::Set(d8, static_cast<std::uint8_t>(least));
  for (std::ptrdiff_t k{0};; k += bytes_of_vector) {
    const auto first = hn::FindFirstTrue(d8, hn::Eq(hn::Load(d8, costs + k), leasts));
    if (first >= 0) return static_cast<std::uint8_t>(k + first);
  }
}

TopRowCosts TopCosts(const TopImages& images, int v, const TopRules& rules, std::uint8_t* memory) {
  const Bytes d8;
  const int width{images.left.width()};
  const int points{top_columns(width)};
  const int pitch{padded_upright({0, rules.disparities})};
  DifferingBits bits{width, pitch, memory};
  bits.take_entering(images.left.row(v), images.right_reversed.row(v));
  bits.take_leaving(images.left.row(v + 1), images.right_reversed.row(v + 1));
  constexpr int margin{top_half_columns + 1};
  std::uint8_t* columns{memory + (DifferingBits::memory(width, pitch) + 63) / 64 * 64 + margin * pitch};
  for (int point{0}; point < points; ++point) {
    const int u{top_pixel(point, points)};
    const auto pixel = bits.pixel(u, bits.right(u));
#pragma GCC unroll 2
    for (int i{0}; i < pitch / bytes_of_vector; ++i) {
      const auto both = hn::Add(DifferingBits::entering(pixel, i), DifferingBits::leaving(pixel, i));
      hn::Store(both, d8, columns + point * pitch + i * bytes_of_vector);
    }
  }
  const std::uint8_t* last{columns + (points - 1) * pitch};
  for (int i{1}; i <= margin; ++i) {
    std::copy_n(columns, pitch, columns - i * pitch);
    std::copy_n(last, pitch, columns + (points - 1 + i) * pitch);
  }
  std::uint8_t* costs{columns + (points + margin) * pitch};
  for (int k{0}; k < pitch; k += bytes_of_vector) {
    // behind the last disparity the highest ones
    const auto searched = hn::FirstN(d8, static_cast<std::size_t>(std::max(rules.disparities - k, 0)));
    const auto behind = hn::IfThenElse(searched, hn::Zero(d8), hn::Set(d8, std::uint8_t{255}));
    const auto column = [&](int point) { return hn::Load(d8, columns + point * pitch + k); };
    auto sum = hn::Zero(d8);  // one column too many, which the first step takes away
    for (int i{-margin}; i < top_half_columns; ++i) sum = hn::Add(sum, column(i));
#pragma GCC unroll 4
    for (int point{0}; point < points; ++point) {
      sum = hn::Add(sum, hn::Sub(column(point + top_half_columns), column(point - margin)));
      hn::Store(hn::Or(sum, behind), d8, costs + point * pitch + k);
    }
  }
  std::uint8_t* best{costs + points * pitch};
  for (int point{0}; point < points; ++point) best[point] = Cheapest(costs + point * pitch, pitch, rules.cost_limit);
  return {costs, pitch, best};
}

#else

TopRowCosts TopCosts(const TopImages&, int, const TopRules&, std::uint8_t*) {
  return {};
}

#endif

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(TopCosts);

TopRowCosts top_costs(const TopImages& images, int v, const TopRules& rules, std::uint8_t* memory) {
  return HWY_DYNAMIC_DISPATCH(TopCosts)(images, v, rules, memory);
}

}  // namespace stereogrid
#endif
