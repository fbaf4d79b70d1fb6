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

void TopCosts(const TopImages& images, int v, int disparities, std::uint8_t* columns, std::uint8_t* costs) {
  const hn::ScalableTag<std::uint8_t> d;
  const std::size_t lanes{hn::Lanes(d)};
  const std::size_t pitch{TopsWorkspace::pitch(disparities)};
  const std::size_t size{static_cast<std::size_t>(disparities)};
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
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(TopCosts);

void top_costs(const TopImages& images, int v, int disparities, std::uint8_t* columns, std::uint8_t* costs) {
  HWY_DYNAMIC_DISPATCH(TopCosts)(images, v, disparities, columns, costs);
}

}  // namespace stereogrid
#endif
