// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "terrain/polar_places_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                             // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include "geometry/relief.hpp"
#include "terrain/polar_places.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

using Floats = hn::CappedTag<float, PolarPlaces::size>;
using Ints = hn::RebindToSigned<Floats>;
using VFloat = hn::Vec<Floats>;
using VInt = hn::Vec<Ints>;

HWY_INLINE VFloat floats(float value) {
  return hn::Set(Floats{}, value);
}
HWY_INLINE VInt ints(int value) {
  return hn::Set(Ints{}, value);
}

// Sector of points; outside the image one before the first, or behind the last one.
HWY_INLINE VInt sector_at(const PolarGeometry& geometry, VFloat ahead_m, VFloat left_m) {
  constexpr float width_px{sector_px};
  const VFloat u{hn::Sub(floats(geometry.cx_px), hn::Div(hn::Mul(floats(geometry.focal_px), left_m), ahead_m))};
  const VFloat limited{hn::Min(hn::Max(u, floats(-width_px)), floats(geometry.width_px))};
  return hn::Sub(whole(hn::Add(hn::Mul(limited, floats(1 / width_px)), floats(1))), ints(1));
}

// A cell at the image's border has its sector.
void FindPlaces(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy, PolarPlaces& places) {
  const Floats d;
  const VFloat half{floats(geometry.half_m)};
  for (int i{0}; i < PolarPlaces::size; i += static_cast<int>(hn::Lanes(d))) {
    const VInt steps{hn::Mul(numbers_from(Ints{}, i), ints(step))};
    const VFloat column{hn::ConvertTo(d, hn::Add(ints(ix), steps))};
    const VFloat x{hn::Add(floats(cells.x_of(0, iy)), hn::Mul(floats(cells.along), column))};
    const VFloat y{hn::Add(floats(cells.y_of(0, iy)), hn::Mul(floats(cells.across), column))};
    const VFloat ahead{hn::Max(x, half)};
    const VFloat disparity{hn::Div(floats(geometry.focal_baseline_pxm), ahead)};
    const VFloat place{hn::Mul(disparity, floats(geometry.ring_places_per_px))};
    const VInt first{hn::Max(sector_at(geometry, ahead, hn::Add(y, half)), ints(0))};
    const VInt right{sector_at(geometry, ahead, hn::Sub(y, half))};
    const VInt least{hn::IfThenElse(hn::Lt(right, first), ints(-1), first)};
    const VInt last{hn::Max(hn::Max(hn::Sub(right, ints(1)), sector_at(geometry, ahead, y)), least)};
    const auto is_ahead = hn::RebindMask(Ints{}, hn::Gt(x, half));
    hn::StoreU(x, d, &places.x[static_cast<std::size_t>(i)]);
    hn::StoreU(whole(hn::Min(place, floats(geometry.ring_places))), Ints{}, &places.ring[static_cast<std::size_t>(i)]);
    hn::StoreU(first, Ints{}, &places.first[static_cast<std::size_t>(i)]);
    hn::StoreU(hn::IfThenElse(is_ahead, hn::Min(last, ints(geometry.last_sector)), ints(-1)), Ints{},
               &places.last[static_cast<std::size_t>(i)]);
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(FindPlaces);

void find_places(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy,
                 PolarPlaces& places) {
  HWY_DYNAMIC_DISPATCH(FindPlaces)(geometry, cells, ix, step, iy, places);
}

}  // namespace stereogrid
#endif
