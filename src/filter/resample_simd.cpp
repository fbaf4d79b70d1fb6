// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; each goes
// through the operations of `resample` in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/resample_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                        // IWYU pragma: keep
// after foreach_target
#include "filter/model.hpp"
#include "filter/partial_vectors_simd.hpp"
#include "filter/resample_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

#include "filter/cell_formulas.hpp"

using Floats = hn::Rebind<float, hn::CappedTag<double, 8>>;

// Cells ix, ix + 1 … of row iy.
template <class D>
class ResampledCells {
 public:
  ResampledCells(D d, const Resampling& resampling, int ix, int iy)
      : d_{d}, world_{resampling.world}, to_{resampling.vehicle}, ix_{ix}, iy_{iy}, cells_{resampling.cells} {
    const GridGeometry& grid{cells_.grid};
    const Real at{hn::Add(hn::Iota(reals_, ix), real(0.5))};
    const Real x{hn::Add(real(grid.x_min_m), hn::Mul(at, real(grid.cell_size_m)))};
    const Real y{real(grid.y_min_m + (iy + 0.5) * grid.cell_size_m)};
    const Real c{real(cells_.cos_yaw)};
    const Real s{real(cells_.sin_yaw)};
    const Real along{hn::Sub(hn::Add(real(cells_.x_m), hn::Mul(c, x)), hn::Mul(s, y))};
    const Real across{hn::Add(hn::Add(real(cells_.y_m), hn::Mul(s, x)), hn::Mul(c, y))};
    const GridGeometry& window{world_.geometry};
    x_ = hn::Div(hn::Sub(along, real(window.x_min_m)), real(window.cell_size_m));
    y_ = hn::Div(hn::Sub(across, real(window.y_min_m)), real(window.cell_size_m));
    const auto is_inside = hn::And(hn::And(hn::Ge(x_, real(0)), hn::Lt(x_, real(window.nx))),
                                   hn::And(hn::Ge(y_, real(0)), hn::Lt(y_, real(window.ny))));
    x_ = hn::IfThenElseZero(is_inside, x_);
    y_ = hn::IfThenElseZero(is_inside, y_);
    inside_ = hn::DemoteTo(ints_, hn::IfThenElseZero(is_inside, real(1)));
  }

  void run() const {
    const auto is_inside = hn::RebindMask(d_, hn::Gt(inside_, hn::Zero(ints_)));
    const Around around{around_each()};
    store(hn::IfThenElse(is_inside, smooth(world_.occupancy, around), hn::Set(d_, 0.5f)), to_.occupancy);
    store(hn::IfThenElseZero(is_inside, smooth(world_.moving, around)), to_.moving);
    const Int nearest{index(hn::DemoteTo(ints_, x_), hn::DemoteTo(ints_, y_))};
    const V never{hn::Set(d_, std::numeric_limits<float>::infinity())};
    store(hn::IfThenElse(is_inside, at(world_.age_s, nearest), never), to_.age_s);
    const EstimateOfVelocity<V> v{
        (turned)(EstimateOfVelocity<V>{at(world_.velocity_x, nearest), at(world_.velocity_y, nearest),
                                       at(world_.velocity_xx, nearest), at(world_.velocity_xy, nearest),
                                       at(world_.velocity_yy, nearest)},
                 V{hn::Set(d_, static_cast<float>(cells_.cos_yaw))},
                 V{hn::Set(d_, static_cast<float>(cells_.sin_yaw))})};
    store(hn::IfThenElseZero(is_inside, v.x), to_.velocity_x);
    store(hn::IfThenElseZero(is_inside, v.y), to_.velocity_y);
    store(hn::IfThenElseZero(is_inside, v.xx), to_.velocity_xx);
    store(hn::IfThenElseZero(is_inside, v.xy), to_.velocity_xy);
    store(hn::IfThenElseZero(is_inside, v.yy), to_.velocity_yy);
  }

 private:
  using V = hn::Vec<D>;
  using Reals = hn::Rebind<double, D>;
  using Ints = hn::RebindToSigned<D>;
  using Real = hn::Vec<Reals>;
  using Int = hn::Vec<Ints>;

  // Where the four cells around lie, and how far between them.
  struct Around {
    Int low_left;
    Int low_right;
    Int high_left;
    Int high_right;
    V fx;
    V fy;
  };

  [[nodiscard]] Real real(double value) const { return hn::Set(reals_, value); }
  [[nodiscard]] Int within(Int cell, int count) const {
    return hn::Min(hn::Max(cell, hn::Zero(ints_)), hn::Set(ints_, count - 1));
  }
  [[nodiscard]] Int index(Int x, Int y) const {
    const auto pitch = static_cast<int>(world_.age_s.view().pitch);
    return hn::Add(hn::Mul(y, hn::Set(ints_, pitch)), x);
  }
  [[nodiscard]] V at(const Image<float>& layer, Int cell) const { return hn::GatherIndex(d_, layer.view().data, cell); }

  [[nodiscard]] Around around_each() const {
    const Real x{hn::Sub(x_, real(0.5))};
    const Real y{hn::Sub(y_, real(0.5))};
    const Real left{hn::Floor(x)};
    const Real low{hn::Floor(y)};
    const Int ix{hn::DemoteTo(ints_, left)};
    const Int iy{hn::DemoteTo(ints_, low)};
    const Int next{hn::Set(ints_, 1)};
    const Int lefts{within(ix, world_.geometry.nx)};
    const Int rights{within(hn::Add(ix, next), world_.geometry.nx)};
    const Int lows{within(iy, world_.geometry.ny)};
    const Int highs{within(hn::Add(iy, next), world_.geometry.ny)};
    return {index(lefts, lows),
            index(rights, lows),
            index(lefts, highs),
            index(rights, highs),
            hn::DemoteTo(d_, hn::Sub(x, left)),
            hn::DemoteTo(d_, hn::Sub(y, low))};
  }

  [[nodiscard]] V smooth(const Image<float>& layer, const Around& cells) const {
    return (among)(at(layer, cells.low_left), at(layer, cells.low_right), at(layer, cells.high_left),
                   at(layer, cells.high_right), cells.fx, cells.fy);
  }

  void store(V value, Image<float>& layer) const { hn::StoreU(value, d_, layer.row(iy_) + ix_); }

  D d_;
  Reals reals_{};
  Ints ints_{};
  const GridLayers& world_;
  GridLayers& to_;
  int ix_;
  int iy_;
  const GridInVehicle& cells_;
  Real x_;  // place of each centre, in cells of the window; outside of it 0
  Real y_;
  Int inside_;
};

void ResampleCells(const Resampling& resampling, int begin, int end, int iy) {
  for_shrinking_vectors(Floats{}, begin, end, [&](auto d, int ix) {
    ResampledCells<decltype(d)>{d, resampling, ix, iy}.run();
  });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(ResampleCells);

void resample_cells(const Resampling& resampling, int begin, int end, int iy) {
  HWY_DYNAMIC_DISPATCH(ResampleCells)(resampling, begin, end, iy);
}

}  // namespace stereogrid
#endif
