// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row of a block;
// every element goes through the operations of cell_formulas.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/joint/joint_update_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                  // IWYU pragma: keep
// after foreach_target
#include "filter/joint/joint_simd.hpp"
#include "filter/resampling/partial_vectors_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

#include "filter/cell_formulas.hpp"

using Float = hn::CappedTag<float, block_columns>;

// The bits by which observations differ from ½ are collected: one test for all rows.
bool IsAnyObserved(View<const float> observed, const CellBox& cells) {
  bool is_any{false};
  for_shrinking_vectors(Float{}, cells.x_first, cells.x_last + 1, [&](auto d, int x) {
    const hn::RebindToUnsigned<decltype(d)> bits;
    const auto half = hn::BitCast(bits, hn::Set(d, 0.5f));
    auto others = hn::Zero(bits);
    for (int y{cells.y_first}; y <= cells.y_last; ++y) {
      others = hn::Or(others, hn::Xor(hn::BitCast(bits, hn::LoadU(d, observed.row(y) + x)), half));
    }
    is_any = is_any || !hn::AllTrue(bits, hn::Eq(others, hn::Zero(bits)));
  });
  return is_any;
}

// The update of a vector of cells: those from column i of the row on.
template <class D>
class Updating {
 public:
  using V = hn::Vec<D>;

  Updating(D d, const JointStep& joint, View<const float> observed, BlockRow& row, GridLayers& layers, int i)
      : d_{d},
        joint_{joint},
        row_{row},
        layers_{layers},
        i_{i},
        x_{row.x + i},
        observed_{hn::LoadU(d, observed.row(row.y) + x_)} {}

  void run(const BlockRowSums* sums) const {
    const bool is_even{sums == nullptr};
    write(is_even ? evenly() : of_masses(*sums), is_even && row_.was_even);
  }

 private:
  [[nodiscard]] V load(const float* of_columns) const { return hn::LoadU(d_, of_columns + i_); }
  void keep(V value, float* of_columns) const { hn::StoreU(value, d_, of_columns + i_); }
  void store(V value, Image<float>& image) const { hn::StoreU(value, d_, image.row(row_.y) + x_); }

  [[nodiscard]] CellLikelihood<V> likelihood() const {
    const float* const table{joint_.tables.likelihood.data()};
    return likelihood_of_cell([&](auto i) { return hn::GatherIndex(d_, table, i); }, observed_);
  }
  [[nodiscard]] ViewOfCell<V> view() const {
    const hn::RebindToSigned<D> whole_numbers;
    const V x{hn::ConvertTo(d_, numbers_from(whole_numbers, x_))};
    return (view_of_cell)(joint_.step, x, V{hn::Set(d_, static_cast<float>(row_.y))});
  }

  // `stereogrid::is_known` of the observation.
  [[nodiscard]] auto is_known() const {
    const V half{hn::Set(d_, 0.5f)};
    const V unsure{hn::Set(d_, 0.05f)};
    return hn::Or(hn::Gt(hn::Sub(observed_, half), unsure), hn::Gt(hn::Sub(half, observed_), unsure));
  }

  [[nodiscard]] CellAfter<V> evenly() const {
    const auto is_unseen = hn::And(hn::Gt(load(row_.unseen), hn::Zero(d_)), hn::Eq(observed_, hn::Set(d_, 0.5f)));
    return (updated_evenly)(joint_.step, load(row_.standing), load(row_.each), load(row_.age_s), is_unseen,
                            likelihood(), view());
  }

  [[nodiscard]] CellAfter<V> of_masses(const BlockRowSums& row) const {
    const LatticeSums<V> sums{load(row.mass), load(row.x), load(row.y), load(row.xx), load(row.xy), load(row.yy)};
    const UpdateOfCell<V> update{
        (joint_update)(joint_.step, sums.mass, load(row_.standing), load(row_.age_s), likelihood(), view())};
    keep(update.scale, row_.scale);
    keep(update.birth_moving, row_.birth_moving);
    keep(update.birth_static, row_.birth_static);
    const V standing{hn::Add(hn::Mul(update.scale, load(row_.standing)), update.birth_static)};
    return {update.occupancy, standing, (updated)(joint_.step, update, sums)};
  }

  // `stays_even`: the mean velocity is 0, and has been.
  void write(const CellAfter<V>& cell, bool stays_even) const {
    FilterState& after{joint_.after};
    store(cell.occupancy, after.occupancy);
    store(cell.occupancy, layers_.occupancy);
    store(cell.standing, after.standing);
    store(moving_share(cell.occupancy, cell.standing), layers_.moving);
    const V older{hn::Add(load(row_.age_s), hn::Set(d_, joint_.dt_s))};
    const V age_s{hn::IfThenZeroElse(is_known(), older)};
    store(age_s, after.age_s);
    store(age_s, layers_.age_s);
    const EstimateOfVelocity<V> velocity{estimate_of(cell.sums)};
    store(velocity.xx, layers_.velocity_xx);
    store(velocity.yy, layers_.velocity_yy);
    if (stays_even) return;
    store(velocity.x, layers_.velocity_x);
    store(velocity.y, layers_.velocity_y);
    store(velocity.xy, layers_.velocity_xy);
  }

  D d_;
  const JointStep& joint_;
  BlockRow& row_;
  GridLayers& layers_;
  int i_;
  int x_;
  V observed_;
};

void UpdateRow(const JointStep& joint, View<const float> observed, const BlockRowSums* sums, BlockRow& row,
               GridLayers& layers) {
  for_shrinking_vectors(Float{}, 0, row.columns,
                        [&](auto d, int i) { Updating<decltype(d)>{d, joint, observed, row, layers, i}.run(sums); });
}

void SumRow(const FilterTables& tables, const float* masses, BlockRowSums& sums) {
  for_shrinking_vectors(Float{}, 0, block_columns, [&](auto d, int column) {
    auto sum = no_sums(hn::Zero(d));
    const float* of_velocity{masses + column};
    for (const float vy_mps : tables.axis_mps) {
      auto row = no_row_sums(hn::Zero(d));
      for (const float vx_mps : tables.axis_mps) {
        row.add(hn::Set(d, vx_mps), hn::LoadU(d, of_velocity));
        of_velocity += block_cells;
      }
      sum.add(hn::Set(d, vy_mps), row);
    }
    hn::StoreU(sum.mass, d, sums.mass + column);
    hn::StoreU(sum.x, d, sums.x + column);
    hn::StoreU(sum.y, d, sums.y + column);
    hn::StoreU(sum.xx, d, sums.xx + column);
    hn::StoreU(sum.xy, d, sums.xy + column);
    hn::StoreU(sum.yy, d, sums.yy + column);
  });
}

void RescaleRow(const FilterStep& step, const BlockRow& row, float* masses) {
  const int velocities{step.velocities()};
  const int standstill{step.standstill()};
  for_shrinking_vectors(Float{}, 0, row.columns, [&](auto d, int i) {
    const auto scale = hn::LoadU(d, row.scale + i);
    const auto moving = hn::LoadU(d, row.birth_moving + i);
    const auto standing = hn::LoadU(d, row.birth_static + i);
    float* of_velocity{masses + i};
    for (int k{0}; k < velocities; ++k, of_velocity += block_cells) {
      const auto kept = hn::Mul(scale, hn::LoadU(d, of_velocity));
      hn::StoreU(hn::Add(kept, k == standstill ? standing : moving), d, of_velocity);
    }
  });
  if (row.columns == block_columns) return;
  for (int k{0}; k < velocities; ++k, masses += block_cells) {
    std::fill(masses + row.columns, masses + block_columns, 0.0f);
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(IsAnyObserved);
HWY_EXPORT(UpdateRow);
HWY_EXPORT(SumRow);
HWY_EXPORT(RescaleRow);

bool is_any_observed(View<const float> observed, const CellBox& cells) {
  return HWY_DYNAMIC_DISPATCH(IsAnyObserved)(observed, cells);
}
void update_row(const JointStep& joint, View<const float> observed, const BlockRowSums* sums, BlockRow& row,
                GridLayers& layers) {
  HWY_DYNAMIC_DISPATCH(UpdateRow)(joint, observed, sums, row, layers);
}
void sum_row(const FilterTables& tables, const float* masses, BlockRowSums& sums) {
  HWY_DYNAMIC_DISPATCH(SumRow)(tables, masses, sums);
}
void rescale_row(const FilterStep& step, const BlockRow& row, float* masses) {
  HWY_DYNAMIC_DISPATCH(RescaleRow)(step, row, masses);
}

}  // namespace stereogrid
#endif
