// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the row; each goes through the
// operations of plain::find_upright.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "obstacles/segmentation/upright_row_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                           // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "obstacles/segmentation/columns.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int lanes_most{16};
using Floats = hn::CappedTag<float, lanes_most>;
using Ints = hn::RebindToSigned<Floats>;
using VFloat = hn::Vec<Floats>;
using Mask = hn::Mask<Floats>;

HWY_INLINE VFloat floats(float value) {
  return hn::Set(Floats{}, value);
}

// A vector's pixels and those within reach; 0 outside the row.
struct Border {
  static constexpr int size{lanes_most + 2 * edge_reach_px};

  Border(const float* row, int width, int u) {
    const int first{u - edge_reach_px};
    const int begin{std::max(first, 0)};
    std::copy(row + begin, row + std::min(first + size, width), around.begin() + (begin - first));
  }

  std::array<float, size> around{};
};

HWY_INLINE Mask are_upright(hn::Vec<Ints> columns, VFloat d, const UprightRow& limits) {
  const VFloat road{
      hn::Add(floats(limits.road_px), hn::Mul(floats(limits.road_per_px), hn::ConvertTo(Floats{}, columns)))};
  const Mask in_range{hn::And(hn::Gt(d, floats(limits.farthest_px)), hn::Lt(d, floats(limits.nearest_px)))};
  return hn::And(in_range, hn::Le(road, hn::Mul(floats(limits.lowest_share), d)));
}

// Pixels of `count` that belong to neither surface of a depth edge.
HWY_INLINE Mask are_between_surfaces(const float* at, VFloat d, Mask count) {
  const VFloat step{floats(edge_step_px)};
  VFloat most{d};
  for (int away{1}; away <= edge_reach_px; ++away) {
    most = hn::Max(most, hn::Max(hn::LoadU(Floats{}, at - away), hn::LoadU(Floats{}, at + away)));
  }
  const Mask is_behind_another{hn::And(count, hn::Gt(most, hn::Add(d, step)))};
  if (hn::AllFalse(Floats{}, is_behind_another)) return is_behind_another;
  const VFloat nothing{floats(std::numeric_limits<float>::max())};
  VFloat least{d};
  for (int away{1}; away <= edge_reach_px; ++away) {
    for (const float* const beside : {at - away, at + away}) {
      const VFloat other{hn::LoadU(Floats{}, beside)};
      least = hn::Min(least, hn::IfThenElse(hn::Gt(other, hn::Zero(Floats{})), other, nothing));
    }
  }
  return hn::And(is_behind_another, hn::Lt(least, hn::Sub(d, step)));
}

void FindUpright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels) {
  const int lanes{static_cast<int>(hn::Lanes(Floats{}))};
  int size{0};
  for (int u{begin}; u < end; u += lanes) {
    const auto add = [&](const float* at) HWY_ATTR {
      const VFloat d{hn::LoadU(Floats{}, at)};
      const auto columns{numbers_from(Ints{}, u)};
      const Mask inside{hn::FirstN(Floats{}, static_cast<std::size_t>(end - u))};
      const Mask upright{hn::And(inside, are_upright(columns, d, limits))};
      if (hn::AllFalse(Floats{}, upright)) return;
      const Mask taken{hn::AndNot(are_between_surfaces(at, d, upright), upright)};
      if (hn::AllTrue(Floats{}, taken)) {
        hn::StoreU(columns, Ints{}, pixels.columns + size);
        hn::StoreU(d, Floats{}, pixels.disparities + size);
        size += lanes;
        return;
      }
      // one by one: Compress first copies a table of a kilobyte, with some compilers and instruction sets
      std::uint8_t bits[sizeof(std::uint64_t)]{};
      hn::StoreMaskBits(Floats{}, taken, bits);
      for (unsigned left{bits[0] | static_cast<unsigned>(bits[1]) << 8}; left != 0; left &= left - 1) {
        const int i{std::countr_zero(left)};
        pixels.columns[size] = u + i;
        pixels.disparities[size++] = at[i];
      }
    };
    if (u >= edge_reach_px && u + lanes + edge_reach_px <= width) {
      add(row + u);
    } else {
      const Border border{row, width, u};
      add(border.around.data() + edge_reach_px);
    }
  }
  pixels.size = size;
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(FindUpright);

void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(FindUpright)(row, width, begin, end, limits, pixels);
}

}  // namespace stereogrid
#endif
