// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; each goes
// through the operations of `resample` in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/resampling/resample_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                   // IWYU pragma: keep
// after foreach_target
#include "filter/filter.hpp"
#include "filter/resampling/partial_vectors_simd.hpp"
#include "filter/resampling/resample_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

#include "filter/cell_formulas.hpp"

// Cells ix, ix + 1 … of row iy.
template <class D>
class ResampledCells {
 public:
  ResampledCells(D d, const Resampling& resampling, int ix, int iy)
      : d_{d}, world_{resampling.world}, to_{resampling.vehicle}, ix_{ix}, iy_{iy}, cells_{resampling.cells} {
    const CellPlaces& places{resampling.places};
    const V at{hn::ConvertTo(d, numbers_from(ints_, ix))};
    x_ = hn::Add(value(places.x_of(0, iy)), hn::Mul(value(places.along), at));
    y_ = hn::Add(value(places.y_of(0, iy)), hn::Mul(value(places.across), at));
    const GridGeometry& window{world_.geometry};
    is_inside_ = hn::And(hn::And(hn::Ge(x_, value(0)), hn::Lt(x_, value(static_cast<float>(window.nx)))),
                         hn::And(hn::Ge(y_, value(0)), hn::Lt(y_, value(static_cast<float>(window.ny)))));
    x_ = hn::IfThenElseZero(is_inside_, x_);
    y_ = hn::IfThenElseZero(is_inside_, y_);
  }

  void run() const {
    const Around around{around_each()};
    store(hn::IfThenElse(is_inside_, smooth(world_.occupancy, around), value(0.5f)), to_.occupancy);
    store(hn::IfThenElseZero(is_inside_, smooth(world_.moving, around)), to_.moving);
    const Int nearest{index(whole(x_), whole(y_))};
    const V never{value(std::numeric_limits<float>::infinity())};
    store(hn::IfThenElse(is_inside_, at(world_.age_s, nearest), never), to_.age_s);
    const EstimateOfVelocity<V> v{
        (turned)(EstimateOfVelocity<V>{at(world_.velocity_x, nearest), at(world_.velocity_y, nearest),
                                       at(world_.velocity_xx, nearest), at(world_.velocity_xy, nearest),
                                       at(world_.velocity_yy, nearest)},
                 V{value(static_cast<float>(cells_.cos_yaw))}, V{value(static_cast<float>(cells_.sin_yaw))})};
    store(hn::IfThenElseZero(is_inside_, v.x), to_.velocity_x);
    store(hn::IfThenElseZero(is_inside_, v.y), to_.velocity_y);
    store(hn::IfThenElseZero(is_inside_, v.xx), to_.velocity_xx);
    store(hn::IfThenElseZero(is_inside_, v.xy), to_.velocity_xy);
    store(hn::IfThenElseZero(is_inside_, v.yy), to_.velocity_yy);
  }

  // All around lies inside, in even blocks.
  void run_even(bool were_even) const {
    const Around around{around_each()};
    store(smooth(world_.occupancy, around), to_.occupancy);
    store(smooth(world_.moving, around), to_.moving);
    const Int nearest{index(whole(x_), whole(y_))};
    store(at(world_.age_s, nearest), to_.age_s);
    const V variance{at(world_.velocity_xx, nearest)};
    store(variance, to_.velocity_xx);
    store(variance, to_.velocity_yy);
    if (were_even) return;
    for (Image<float>* layer : {&to_.velocity_x, &to_.velocity_y, &to_.velocity_xy}) store(value(0), *layer);
  }

 private:
  using V = hn::Vec<D>;
  using Ints = hn::RebindToSigned<D>;
  using Int = hn::Vec<Ints>;

  // Four cells around a point, and their weights.
  struct Around {
    Int low_left;
    Int low_right;
    Int high_left;
    Int high_right;
    V fx;
    V fy;
    bool are_pairs;  ///< all right ones lie behind the left ones
  };
  struct Pair {
    V left;
    V right;
  };

  [[nodiscard]] V value(float number) const { return hn::Set(d_, number); }
  [[nodiscard]] Int within(Int cell, int count) const {
    return hn::Min(hn::Max(cell, hn::Zero(ints_)), hn::Set(ints_, count - 1));
  }
  [[nodiscard]] Int index(Int x, Int y) const {
    const auto pitch = static_cast<int>(world_.age_s.view().pitch);
    return hn::Add(hn::Mul(y, hn::Set(ints_, pitch)), x);
  }
  [[nodiscard]] V at(const Image<float>& layer, Int cell) const { return hn::GatherIndex(d_, layer.view().data, cell); }

  [[nodiscard]] Around around_each() const {
    const V x{hn::Sub(x_, value(0.5f))};
    const V y{hn::Sub(y_, value(0.5f))};
    const V left{hn::Floor(x)};
    const V low{hn::Floor(y)};
    const Int ix{whole(left)};
    const Int iy{whole(low)};
    const Int next{hn::Set(ints_, 1)};
    const Int lefts{within(ix, world_.geometry.nx)};
    const Int rights{within(hn::Add(ix, next), world_.geometry.nx)};
    const Int lows{within(iy, world_.geometry.ny)};
    const Int highs{within(hn::Add(iy, next), world_.geometry.ny)};
    return {index(lefts, lows),
            index(rights, lows),
            index(lefts, highs),
            index(rights, highs),
            hn::Sub(x, left),
            hn::Sub(y, low),
            hn::AllTrue(ints_, hn::Eq(hn::Add(lefts, next), rights))};
  }

  [[nodiscard]] V smooth(const Image<float>& layer, const Around& cells) const {
    const Pair low{cells.are_pairs ? pair_at(layer, cells.low_left)
                                   : Pair{at(layer, cells.low_left), at(layer, cells.low_right)}};
    const Pair high{cells.are_pairs ? pair_at(layer, cells.high_left)
                                    : Pair{at(layer, cells.high_left), at(layer, cells.high_right)}};
    return (among)(low.left, low.right, high.left, high.right, cells.fx, cells.fy);
  }

  // Each cell and the one behind it. Where there are gathers, one of 64 bits is faster than two of 32.
  [[nodiscard]] Pair pair_at(const Image<float>& layer, Int left) const {
#if HWY_TARGET <= HWY_AVX2
    if constexpr (hn::MaxLanes(D{}) >= 8) {
      const hn::Repartition<std::int64_t, D> pairs;
      const hn::Half<Ints> half;
      const auto* const cells = reinterpret_cast<const std::int64_t*>(layer.view().data);
      const auto gathered = [&](auto of) HWY_ATTR {
        return hn::BitCast(d_, hn::GatherOffset(pairs, cells, hn::ShiftLeft<2>(hn::PromoteTo(pairs, of))));
      };
      const V lower{gathered(hn::LowerHalf(half, left))};
      const V upper{gathered(hn::UpperHalf(half, left))};
      return {hn::ConcatEven(d_, upper, lower), hn::ConcatOdd(d_, upper, lower)};
    }
#endif
    return {at(layer, left), at(layer, hn::Add(left, hn::Set(ints_, 1)))};
  }

  void store(V value, Image<float>& layer) const {
    hn::StoreU(value, d_, layer.row(iy_) + ix_);
  }

  D d_;
  Ints ints_{};
  const GridLayers& world_;
  GridLayers& to_;
  int ix_;
  int iy_;
  const GridInVehicle& cells_;
  V x_;  // place of each centre, in cells of the window; outside of it 0
  V y_;
  hn::Mask<D> is_inside_;
};

void ResampleCells(const Resampling& resampling, int begin, int end, int iy) {
  for_shrinking_vectors(hn::CappedTag<float, resampled_columns>{}, begin, end, [&](auto d, int ix) {
    ResampledCells<decltype(d)>{d, resampling, ix, iy}.run();
  });
}

void ResampleEvenCells(const Resampling& resampling, int begin, int end, int iy, bool were_even) {
  for_shrinking_vectors(hn::CappedTag<float, resampled_columns>{}, begin, end, [&](auto d, int ix) {
    ResampledCells<decltype(d)>{d, resampling, ix, iy}.run_even(were_even);
  });
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(ResampleCells);
HWY_EXPORT(ResampleEvenCells);

void resample_cells(const Resampling& resampling, int begin, int end, int iy) {
  HWY_DYNAMIC_DISPATCH(ResampleCells)(resampling, begin, end, iy);
}
void resample_even_cells(const Resampling& resampling, int begin, int end, int iy, bool were_even) {
  HWY_DYNAMIC_DISPATCH(ResampleEvenCells)(resampling, begin, end, iy, were_even);
}

}  // namespace stereogrid
#endif
