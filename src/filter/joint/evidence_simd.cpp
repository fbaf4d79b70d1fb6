// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along neighbouring cells; every element
// goes through the operations of evidence.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/joint/evidence_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                              // IWYU pragma: keep
// after foreach_target
#include "filter/joint/evidence_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

using Float = hn::CappedTag<float, block_columns>;
using Vector = hn::Vec<Float>;

#include "filter/lattice_formulas.hpp"

struct Evidence {
  Vector x;
  Vector y;
  Vector xx;
  Vector xy;
  Vector yy;
};

// The cells of a vector: those from `lane` on.
class Weighing {
 public:
  Weighing(const std::vector<float>& axis_mps, float* space, WeighedCells& cells, int lane)
      : axis_mps_{axis_mps}, space_{space + lane}, cells_{cells}, lane_{lane} {}

  [[nodiscard]] bool is_needed() const {
    for (std::size_t i{0}; i < hn::Lanes(Float{}); ++i) {
      if (cells_.is_weighed[lane_ + static_cast<int>(i)]) return true;
    }
    return false;
  }

  void run() const { cells_.masses != nullptr ? run<true>() : run<false>(); }

 private:
  static Vector set(float value) { return hn::Set(Float{}, value); }
  [[nodiscard]] Vector load(const float* of_cells) const { return hn::LoadU(Float{}, of_cells + lane_); }
  void store(Vector v, float* of_cells) const { hn::StoreU(v, Float{}, of_cells + lane_); }
  [[nodiscard]] std::size_t side() const { return axis_mps_.size(); }
  [[nodiscard]] std::size_t standstill() const { return side() * side() / 2; }
  [[nodiscard]] float* masses(std::size_t k) const { return cells_.masses + k * block_cells + lane_; }
  [[nodiscard]] float* weighed(std::size_t k) const { return space_ + k * block_columns; }

  template <bool has_masses>
  void run() const {
    rescale<has_masses>(apply<has_masses>());
  }

  // The masses times their likelihoods; returns the scale that keeps their sum.
  template <bool has_masses>
  [[nodiscard]] Vector apply() const {
    const Float d;
    const Evidence evidence{load(cells_.x), load(cells_.y_mps), load(cells_.xx), load(cells_.xy), load(cells_.yy)};
    float* const along_x{weighed(side() * side())};  // squares and cross of each v_x
    for (std::size_t i{0}; i < side(); ++i) {
      const DistanceAlongX<Vector> distance{distance_along_x(evidence, set(axis_mps_[i]))};
      hn::StoreU(distance.squares, d, along_x + 2 * i * block_columns);
      hn::StoreU(distance.cross, d, along_x + (2 * i + 1) * block_columns);
    }
    const Vector each{load(cells_.each)};
    const Vector standing{load(cells_.standing)};
    Vector before{set(0)};
    Vector after{set(0)};
    std::size_t k{0};
    for (const float vy_mps : axis_mps_) {
      const Vector y{hn::Sub(set(vy_mps), evidence.y)};
      const Vector y_squares{hn::Mul(hn::Mul(evidence.yy, y), y)};
      Vector row_before{set(0)};
      Vector row_after{set(0)};
      for (const float* along{along_x}; along != along_x + 2 * side() * block_columns;
           along += 2 * block_columns, ++k) {
        const Vector here{has_masses ? hn::LoadU(d, masses(k)) : (k == standstill() ? standing : each)};
        const DistanceAlongX<Vector> distance{hn::LoadU(d, along), hn::LoadU(d, along + block_columns)};
        const Vector product{hn::Mul(here, likelihood_at(distance, y, y_squares))};
        row_before = hn::Add(row_before, here);
        row_after = hn::Add(row_after, product);
        hn::StoreU(product, d, weighed(k));
      }
      before = hn::Add(before, row_before);
      after = hn::Add(after, row_after);
    }
    return hn::IfThenElse(hn::Gt(after, set(0)), hn::Div(before, after), set(1));
  }

  template <bool has_masses>
  void rescale(Vector scale) const {
    const Float d;
    float is_weighed[block_columns];
    for (int i{0}; i < block_columns; ++i) is_weighed[i] = cells_.is_weighed[i] ? 1.0f : 0.0f;
    const auto is_kept = hn::Eq(load(is_weighed), set(0));
    LatticeSums<Vector> sum{no_sums(set(0))};
    std::size_t k{0};
    for (const float vy_mps : axis_mps_) {
      LatticeRowSums<Vector> row{no_row_sums(set(0))};
      for (const float vx_mps : axis_mps_) {
        const Vector mass{hn::Mul(hn::LoadU(d, weighed(k)), scale)};
        row.add(set(vx_mps), mass);
        if constexpr (has_masses) {
          hn::StoreU(hn::IfThenElse(is_kept, hn::LoadU(d, masses(k)), mass), d, masses(k));
        }
        ++k;
      }
      sum.add(set(vy_mps), row);
    }
    store(hn::Mul(hn::LoadU(d, weighed(standstill())), scale), cells_.standing);
    store(sum.mass, cells_.sum_mass);
    store(sum.x, cells_.sum_x);
    store(sum.y, cells_.sum_y);
    store(sum.xx, cells_.sum_xx);
    store(sum.xy, cells_.sum_xy);
    store(sum.yy, cells_.sum_yy);
  }

  const std::vector<float>& axis_mps_;
  float* space_;
  WeighedCells& cells_;
  int lane_;
};

void WeighCells(const std::vector<float>& axis_mps, float* space, WeighedCells& cells) {
  for (int lane{0}; lane < block_columns; lane += static_cast<int>(hn::Lanes(Float{}))) {
    const Weighing weighing{axis_mps, space, cells, lane};
    if (weighing.is_needed()) weighing.run();
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(WeighCells);

void weigh_cells(const std::vector<float>& axis_mps, float* space, WeighedCells& cells) {
  HWY_DYNAMIC_DISPATCH(WeighCells)(axis_mps, space, cells);
}

}  // namespace stereogrid
#endif
