// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
namespace stereogrid {
namespace HWY_NAMESPACE {
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

  void run() const { rescale(apply()); }

 private:
  static Vector set(float value) { return hn::Set(Float{}, value); }
  [[nodiscard]] Vector load(const float* of_cells) const { return hn::LoadU(Float{}, of_cells + lane_); }
  void store(Vector v, float* of_cells) const { hn::StoreU(v, Float{}, of_cells + lane_); }
  [[nodiscard]] std::size_t standstill() const { return axis_mps_.size() * axis_mps_.size() / 2; }
  [[nodiscard]] float* masses(std::size_t k) const { return cells_.masses + k * block_cells + lane_; }
  [[nodiscard]] Vector mass(std::size_t k) const {
    if (cells_.masses != nullptr) return hn::LoadU(Float{}, masses(k));
    return load(k == standstill() ? cells_.standing : cells_.each);
  }

  // The masses times their likelihoods; returns the scale that keeps their sum.
  [[nodiscard]] Vector apply() const {
    Vector before{set(0)};
    Vector after{set(0)};
    std::size_t k{0};
    const Evidence evidence{load(cells_.x), load(cells_.y_mps), load(cells_.xx), load(cells_.xy), load(cells_.yy)};
    for (const float vy_mps : axis_mps_) {
      Vector row_before{set(0)};
      Vector row_after{set(0)};
      for (const float vx_mps : axis_mps_) {
        const Vector here{mass(k)};
        const Vector weighed{hn::Mul(here, likelihood_of(evidence, set(vx_mps), set(vy_mps)))};
        row_before = hn::Add(row_before, here);
        row_after = hn::Add(row_after, weighed);
        hn::StoreU(weighed, Float{}, space_ + block_columns * k++);
      }
      before = hn::Add(before, row_before);
      after = hn::Add(after, row_after);
    }
    return hn::IfThenElse(hn::Gt(after, set(0)), hn::Div(before, after), set(1));
  }

  void rescale(Vector scale) const {
    float is_weighed[block_columns];
    for (int i{0}; i < block_columns; ++i) is_weighed[i] = cells_.is_weighed[i] ? 1.0f : 0.0f;
    const auto weighed = hn::Gt(load(is_weighed), set(0));
    LatticeSums<Vector> sum{no_sums(set(0))};
    std::size_t k{0};
    for (const float vy_mps : axis_mps_) {
      LatticeRowSums<Vector> row{no_row_sums(set(0))};
      for (const float vx_mps : axis_mps_) {
        const Vector mass{hn::Mul(hn::LoadU(Float{}, space_ + block_columns * k), scale)};
        row.add(set(vx_mps), mass);
        if (k == standstill()) store(mass, cells_.standing);
        if (cells_.masses != nullptr) {
          hn::StoreU(hn::IfThenElse(weighed, mass, hn::LoadU(Float{}, masses(k))), Float{}, masses(k));
        }
        ++k;
      }
      sum.add(set(vy_mps), row);
    }
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
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(WeighCells);

void weigh_cells(const std::vector<float>& axis_mps, float* space, WeighedCells& cells) {
  HWY_DYNAMIC_DISPATCH(WeighCells)(axis_mps, space, cells);
}

}  // namespace stereogrid
#endif
