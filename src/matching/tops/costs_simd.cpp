// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the disparities.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/tops/costs_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                            // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/tops/tops.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// The first of the least costs; 0 where all exceed the limit. Those behind the last disparity do not count.
std::size_t Cheapest(const std::uint8_t* costs, std::size_t size, std::uint8_t limit) {
  const hn::ScalableTag<std::uint8_t> d;
  const std::size_t lanes{hn::Lanes(d)};
  const auto worst = hn::Set(d, std::uint8_t{255});
  const auto at = [&](std::size_t k) HWY_ATTR {
    const auto some = hn::LoadU(d, costs + k);
    return k + lanes <= size ? some : hn::IfThenElse(hn::FirstN(d, size - k), some, worst);
  };
  auto least = worst;
  for (std::size_t k{0}; k < size; k += lanes) least = hn::Min(least, at(k));
  const auto limits = hn::Set(d, limit);
  if (hn::AllFalse(d, hn::Eq(hn::Min(least, limits), least))) return 0;
  HWY_ALIGN std::uint8_t of_lanes[HWY_MAX_BYTES];
  hn::Store(least, d, of_lanes);
  const auto of_all = hn::Set(d, *std::min_element(of_lanes, of_lanes + lanes));
  std::size_t k{0};
  while (hn::AllFalse(d, hn::Eq(at(k), of_all))) k += lanes;
  return k + static_cast<std::size_t>(hn::FindFirstTrue(d, hn::Eq(at(k), of_all)));
}

void TopCosts(const TopImages& images, int v, const TopRules& rules, std::uint8_t* columns, std::uint8_t* costs,
              std::uint8_t* best) {
  const hn::ScalableTag<std::uint8_t> d;
  const std::size_t lanes{hn::Lanes(d)};
  const std::size_t pitch{TopsWorkspace::pitch(rules.disparities)};
  const std::size_t size{static_cast<std::size_t>(rules.disparities)};
  const int width{images.left.width()};
  const int points{top_columns(width)};
  const auto of = [&](std::uint8_t* values, int point) {
    return values + static_cast<std::size_t>(std::clamp(point, 0, points - 1)) * pitch;
  };
  for (int point{0}; point < points; ++point) {
    const int u{top_pixel(point, points)};
    for (std::size_t k{0}; k < size; k += lanes) {
      const auto differing = [&](int row) {
        const std::uint8_t* right{images.right_reversed.row(row) + (width - 1 - u)};
        return hn::PopulationCount(hn::Xor(hn::Set(d, images.left.row(row)[u]), hn::LoadU(d, right + k)));
      };
      hn::StoreU(hn::Add(differing(v), differing(v + 1)), d, of(columns, point) + k);
    }
  }
  std::fill(costs, costs + pitch, std::uint8_t{0});
  for (int i{-top_half_columns}; i <= top_half_columns; ++i) {
    for (std::size_t k{0}; k < size; ++k) costs[k] = static_cast<std::uint8_t>(costs[k] + of(columns, i)[k]);
  }
  for (int point{1}; point < points; ++point) {
    const std::uint8_t* entering{of(columns, point + top_half_columns)};
    const std::uint8_t* leaving{of(columns, point - top_half_columns - 1)};
    const std::uint8_t* before{of(costs, point - 1)};
    for (std::size_t k{0}; k < size; k += lanes) {
      const auto moved = hn::Sub(hn::LoadU(d, entering + k), hn::LoadU(d, leaving + k));
      hn::StoreU(hn::Add(hn::LoadU(d, before + k), moved), d, of(costs, point) + k);
    }
  }
  for (int point{0}; point < points; ++point) {
    best[point] =
        static_cast<std::uint8_t>(Cheapest(of(costs, point), size, static_cast<std::uint8_t>(rules.cost_limit)));
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(TopCosts);

void top_costs(const TopImages& images, int v, const TopRules& rules, std::uint8_t* columns, std::uint8_t* costs,
               std::uint8_t* best) {
  HWY_DYNAMIC_DISPATCH(TopCosts)(images, v, rules, columns, costs, best);
}

}  // namespace stereogrid
#endif
