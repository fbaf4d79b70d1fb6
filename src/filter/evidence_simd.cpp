// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along neighbouring cells; every element
// goes through the operations of evidence.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/evidence_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                        // IWYU pragma: keep
// after foreach_target
#include "filter/evidence_simd.hpp"
#include "hwy/highway.h"

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Float = hn::CappedTag<float, evidence_cells>;
using Vector = hn::Vec<Float>;

// The cells of a vector: those from `lane` on.
class Weighing {
 public:
  Weighing(const std::vector<float>& axis_mps, FilterState& state, float* masses, WeighedCells& cells, int lane)
      : axis_mps_{axis_mps}, state_{state}, masses_{masses + lane}, cells_{cells}, lane_{lane} {}

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
  [[nodiscard]] float* state(std::size_t k) const { return state_.velocity[k].data() + cells_.first_cell + lane_; }

  // Likelihood at (vx, vy), whose distances from the evidence are x and y.
  [[nodiscard]] Vector likelihood(Vector xx_x_x, Vector xy_x, Vector y, Vector yy_y_y) const {
    const Vector squared_distance{hn::Add(hn::Add(xx_x_x, hn::Mul(xy_x, y)), yy_y_y)};
    const Vector near{hn::Div(set(1), hn::Add(set(1), hn::Mul(set(0.5f), squared_distance)))};
    return hn::Add(set(likelihood_floor), hn::Mul(near, near));
  }

  // The masses times their likelihoods; returns the scale that keeps their sum.
  [[nodiscard]] Vector apply() const {
    Vector before{set(0)};
    Vector after{set(0)};
    std::size_t k{0};
    for (const float vy_mps : axis_mps_) {
      const Vector y{hn::Sub(set(vy_mps), load(cells_.y))};
      const Vector yy_y_y{hn::Mul(hn::Mul(load(cells_.yy), y), y)};
      Vector row_before{set(0)};
      Vector row_after{set(0)};
      for (const float vx_mps : axis_mps_) {
        const Vector x{hn::Sub(set(vx_mps), load(cells_.x))};
        const Vector xx_x_x{hn::Mul(hn::Mul(load(cells_.xx), x), x)};
        const Vector xy_x{hn::Mul(hn::Mul(set(2), load(cells_.xy)), x)};
        const Vector mass{hn::LoadU(Float{}, state(k))};
        const Vector weighed{hn::Mul(mass, likelihood(xx_x_x, xy_x, y, yy_y_y))};
        row_before = hn::Add(row_before, mass);
        row_after = hn::Add(row_after, weighed);
        hn::StoreU(weighed, Float{}, masses_ + evidence_cells * k++);
      }
      before = hn::Add(before, row_before);
      after = hn::Add(after, row_after);
    }
    return hn::IfThenElse(hn::Gt(after, set(0)), hn::Div(before, after), set(1));
  }

  void rescale(Vector scale) const {
    float is_weighed[evidence_cells];
    for (int i{0}; i < evidence_cells; ++i) is_weighed[i] = cells_.is_weighed[i] ? 1.0f : 0.0f;
    const auto weighed = hn::Gt(load(is_weighed), set(0));
    Vector sum_mass{set(0)};
    Vector sum_x{set(0)};
    Vector sum_y{set(0)};
    Vector sum_xx{set(0)};
    Vector sum_xy{set(0)};
    Vector sum_yy{set(0)};
    std::size_t k{0};
    for (const float vy_mps : axis_mps_) {
      Vector row_mass{set(0)};
      Vector row_x{set(0)};
      Vector row_xx{set(0)};
      for (const float vx_mps : axis_mps_) {
        const Vector mass{hn::Mul(hn::LoadU(Float{}, masses_ + evidence_cells * k), scale)};
        row_mass = hn::Add(row_mass, mass);
        row_x = hn::Add(row_x, hn::Mul(set(vx_mps), mass));
        row_xx = hn::Add(row_xx, hn::Mul(set(vx_mps * vx_mps), mass));
        if (k == state_.velocity.size() / 2) store(mass, cells_.standing);
        hn::StoreU(hn::IfThenElse(weighed, mass, hn::LoadU(Float{}, state(k))), Float{}, state(k));
        ++k;
      }
      const Vector vy{set(vy_mps)};
      sum_mass = hn::Add(sum_mass, row_mass);
      sum_x = hn::Add(sum_x, row_x);
      sum_y = hn::Add(sum_y, hn::Mul(vy, row_mass));
      sum_xx = hn::Add(sum_xx, row_xx);
      sum_xy = hn::Add(sum_xy, hn::Mul(vy, row_x));
      sum_yy = hn::Add(sum_yy, hn::Mul(hn::Mul(vy, vy), row_mass));
    }
    store(sum_mass, cells_.sum_mass);
    store(sum_x, cells_.sum_x);
    store(sum_y, cells_.sum_y);
    store(sum_xx, cells_.sum_xx);
    store(sum_xy, cells_.sum_xy);
    store(sum_yy, cells_.sum_yy);
  }

  const std::vector<float>& axis_mps_;
  FilterState& state_;
  float* masses_;
  WeighedCells& cells_;
  int lane_;
};

void WeighCells(const std::vector<float>& axis_mps, FilterState& state, float* masses, WeighedCells& cells) {
  for (int lane{0}; lane < evidence_cells; lane += static_cast<int>(hn::Lanes(Float{}))) {
    const Weighing weighing{axis_mps, state, masses, cells, lane};
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

void weigh_cells(const std::vector<float>& axis_mps, FilterState& state, float* masses, WeighedCells& cells) {
  HWY_DYNAMIC_DISPATCH(WeighCells)(axis_mps, state, masses, cells);
}

}  // namespace stereogrid
#endif
