// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; every element
// goes through the operations of model.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/bof2008/tay_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                           // IWYU pragma: keep
// after foreach_target
#include "filter/bof2008/tay_simd.hpp"
#include "filter/resampling/partial_vectors_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

constexpr std::size_t lanes_max{16};
using Float = hn::CappedTag<float, lanes_max>;

// Row of cells, one more than a tile: values between two columns need both.
struct alignas(64) RowBuffer {
  float cells[tile_columns + lanes_max];
};

/// P(v) and P(occupied, v) of a row's cells.
struct PairBuffer {
  RowBuffer velocity;
  RowBuffer occupied;
};

// Rows of the last state, with the noise of velocity k, and the prior outside the window.
class Source {
 public:
  Source(const LatticeTile& tile, std::size_t k)
      : tile_{tile},
        k_{k},
        border_{prior_of(tile.step, static_cast<int>(k))},
        occupied_border_{border_ * still_occupied(tile.step, 0.5f)},
        from_{tile.after.space.from[k]} {}

  // out[i] = column x_begin + ix + i of row y + iy, for i < count
  void fetch(int y, int count, PairBuffer& out) const {
    const FilterSpace& space{tile_.after.space};
    const auto [row, begin, end] = span(y, count);
    const float* still{space.still_occupied.row(row) + first()};
    fill(0, begin, out);
    if (static_cast<int>(k_) == tile_.step.standstill()) {
      const float* standing{space.standing.row(row) + first()};
      take(begin, end, still, out, [&](auto d, int x) { return hn::LoadU(d, standing + x); });
    } else {
      const float* mass{tile_.before.velocity[k_].row(row) + first()};
      const float* gained{space.gained.row(row) + first()};
      take(begin, end, still, out, [&](auto d, int x) {
        const auto kept = hn::Set(d, tile_.step.kept_moving);
        return disturbed(kept, hn::LoadU(d, mass + x), hn::LoadU(d, gained + x));
      });
    }
    fill(end, count, out);
  }

 private:
  struct Span {
    int row;
    int begin;
    int end;
  };
  [[nodiscard]] int first() const { return tile_.x_begin + from_.ix; }
  // Part of a row within the window.
  [[nodiscard]] Span span(int y, int count) const {
    const int cells{tile_.before.occupancy.width()};
    const int row{y + from_.iy};
    if (row < 0 || row >= cells) return {0, count, count};
    const int begin{std::clamp(-first(), 0, count)};
    return {row, begin, std::clamp(cells - first(), begin, count)};
  }

  void fill(int begin, int end, PairBuffer& out) const {
    std::fill(out.velocity.cells + begin, out.velocity.cells + end, border_);
    std::fill(out.occupied.cells + begin, out.occupied.cells + end, occupied_border_);
  }
  template <class Velocity>
  HWY_INLINE static void take(int begin, int end, const float* still, PairBuffer& out, const Velocity& velocity) {
    for_shrinking_vectors(Float{}, begin, end, [&](auto d, int x) {
      const auto mass = velocity(d, x);
      hn::StoreU(mass, d, out.velocity.cells + x);
      hn::StoreU(hn::Mul(mass, hn::LoadU(d, still + x)), d, out.occupied.cells + x);
    });
  }

  const LatticeTile& tile_;
  std::size_t k_;
  float border_;
  float occupied_border_;
  Antecedents from_;
};

// Sums over the lattice's present row.
struct RowOfLattice {
  float mass[tile_columns];
  float x[tile_columns];
  float xx[tile_columns];
  float all[tile_columns];  // tay2008: Σ l(k)
};

// P(v_k) and P(occupied, v_k), predicted: interpolated between the antecedents along x, then along y; then the update.
// `stands`: velocity k is standstill.
template <bool stands>
HWY_NOINLINE void update_tay(const LatticeTile& tile, std::size_t k, float vx_mps, const PairBuffer* before,
                             TayRow* rows, RowOfLattice* sums) {
  const Antecedents from{tile.after.space.from[k]};
  Image<float>& velocity{tile.after.velocity[k]};
  const int count{tile.rows()};
  for_shrinking_vectors(Float{}, 0, tile.columns(), [&](auto d, int x) {
    const auto fx = hn::Set(d, from.fx);
    const auto fy = hn::Set(d, from.fy);
    const auto vx = hn::Set(d, vx_mps);
    const auto along_x = [&](const RowBuffer& of) {
      return between(hn::LoadU(d, of.cells + x), hn::LoadU(d, of.cells + x + 1), fx);
    };
    auto all = along_x(before[0].velocity);
    auto occupied = along_x(before[0].occupied);
    for (int i{0}; i < count; ++i) {
      const auto next_all = along_x(before[i + 1].velocity);
      const auto next_occupied = along_x(before[i + 1].occupied);
      const auto load = [&](const float* of) { return hn::LoadU(d, of + x); };
      TayRow& row{rows[i]};
      RowOfLattice& sum{sums[i]};
      const auto updated = tay_update(between(all, next_all, fy), between(occupied, next_occupied, fy),
                                      load(row.likelihood_occupied), load(row.likelihood_empty));
      hn::StoreU(updated.all, d, velocity.row(tile.y_begin + i) + tile.x_begin + x);
      if constexpr (stands) hn::StoreU(updated.occupied, d, row.standing + x);
      hn::StoreU(hn::Add(load(sum.all), updated.all), d, sum.all + x);
      LatticeRowSums<hn::Vec<decltype(d)>> of_row{load(sum.mass), load(sum.x), load(sum.xx)};
      of_row.add(vx, updated.occupied);
      hn::StoreU(of_row.mass, d, sum.mass + x);
      hn::StoreU(of_row.x, d, sum.x + x);
      hn::StoreU(of_row.xx, d, sum.xx + x);
      all = next_all;
      occupied = next_occupied;
    }
  });
}

void add_lattice_row(float vy, int columns, const RowOfLattice& row, TileSums& sums) {
  for (int x{0}; x < columns; ++x) {
    VelocitySums cell{sums.at(x)};
    cell.add(vy, {row.mass[x], row.x[x], row.xx[x]});
    sums.mass[x] = cell.mass;
    sums.x[x] = cell.x;
    sums.y[x] = cell.y;
    sums.xx[x] = cell.xx;
    sums.xy[x] = cell.xy;
    sums.yy[x] = cell.yy;
  }
}

void PredictTay(const LatticeTile& tile, TayRow* rows) {
  const int count{tile.rows()};
  PairBuffer before[tile_rows + 1];
  RowOfLattice of_row[tile_rows];
  for (int i{0}; i < count; ++i) {
    std::fill(rows[i].evidence, rows[i].evidence + tile_columns, 0.0f);
    rows[i].sums = {};
  }
  std::size_t k{0};
  for (const float vy_mps : tile.tables.axis_mps) {
    std::fill(of_row, of_row + count, RowOfLattice{});
    for (const float vx_mps : tile.tables.axis_mps) {
      const Source source{tile, k};
      for (int i{0}; i <= count; ++i) source.fetch(tile.y_begin + i, tile.columns() + 1, before[i]);
      const bool stands{static_cast<int>(k) == tile.step.standstill()};
      stands ? update_tay<true>(tile, k, vx_mps, before, rows, of_row)
             : update_tay<false>(tile, k, vx_mps, before, rows, of_row);
      ++k;
    }
    for (int i{0}; i < count; ++i) {
      add_lattice_row(vy_mps, tile.columns(), of_row[i], rows[i].sums);
      for (int x{0}; x < tile.columns(); ++x) rows[i].evidence[x] += of_row[i].all[x];
    }
  }
}

void Normalise(const LatticeTile& tile, int y, const float* scale) {
  for (Image<float>& velocity : tile.after.velocity) {
    float* const mass{velocity.row(y) + tile.x_begin};
    for_shrinking_vectors(Float{}, 0, tile.columns(), [&](auto d, int x) {
      hn::StoreU(hn::Mul(hn::LoadU(d, scale + x), hn::LoadU(d, mass + x)), d, mass + x);
    });
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(PredictTay);
HWY_EXPORT(Normalise);

void normalise(const LatticeTile& tile, int y, const float* scale) {
  HWY_DYNAMIC_DISPATCH(Normalise)(tile, y, scale);
}
void predict_tay(const LatticeTile& tile, TayRow* rows) {
  HWY_DYNAMIC_DISPATCH(PredictTay)(tile, rows);
}

}  // namespace stereogrid
#endif
