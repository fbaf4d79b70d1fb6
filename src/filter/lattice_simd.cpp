// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; every element
// goes through the operations of model.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/lattice_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                       // IWYU pragma: keep
// after foreach_target
#include "filter/lattice_simd.hpp"
#include "hwy/highway.h"
#include "u_disparity/vectors_simd.hpp"

#include <algorithm>
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t lanes_max{16};
using Float = hn::CappedTag<float, lanes_max>;

// A row of cells, one more than a tile has: what lies between two columns needs both.
struct alignas(64) RowBuffer {
  float cells[tile_columns + lanes_max];
};

void blend(const float* first, const float* second, float share, int width, float* out) {
  const Float df;
  const auto of_first = hn::Set(df, 1 - share);
  const auto of_second = hn::Set(df, share);
  for_vectors(df, width, [&](int x, auto n) {
    const auto a = hn::Mul(of_first, load(df, first + x, n));
    store(hn::Add(a, hn::Mul(of_second, load(df, second + x, n))), df, out + x, n);
  });
}

// How rows of the state before are read: with the noise of velocity k, `border` outside the window.
class Source {
 public:
  Source(const LatticeTile& tile, std::size_t k, float border)
      : tile_{tile}, k_{k}, border_{border}, from_{tile.after.space.from[k]} {}

  [[nodiscard]] const Antecedents& from() const { return from_; }

  // out[i] = column x_begin + ix + i of row y + iy, for i < count
  void fetch(int y, int count, float* out) const {
    const FilterSpace& space{tile_.after.space};
    if (static_cast<int>(k_) == tile_.step.standstill()) return copy(space.standing, y, count, border_, out);
    const auto [row, begin, end] = span(y, count);
    const float* mass{tile_.before.velocity[k_].row(row) + first()};
    const float* gained{space.gained.row(row) + first()};
    const Float df;
    const auto kept = hn::Set(df, tile_.step.kept_moving);
    std::fill(out, out + begin, border_);
    for_vectors(df, end - begin, [&](int i, auto n) {
      const auto moving = hn::Mul(kept, load(df, mass + begin + i, n));
      store(hn::Add(moving, load(df, gained + begin + i, n)), df, out + begin + i, n);
    });
    std::fill(out + end, out + count, border_);
  }

  // likewise from an image as it is
  void copy(const Image<float>& image, int y, int count, float border, float* out) const {
    const auto [row, begin, end] = span(y, count);
    const float* cells{image.row(row) + first()};
    std::fill(out, out + begin, border);
    std::copy(cells + begin, cells + end, out + begin);
    std::fill(out + end, out + count, border);
  }

 private:
  struct Span {
    int row;
    int begin;
    int end;
  };
  [[nodiscard]] int first() const { return tile_.x_begin + from_.ix; }
  // What of a row lies in the window.
  [[nodiscard]] Span span(int y, int count) const {
    const int cells{tile_.before.occupancy.width()};
    const int row{y + from_.iy};
    if (row < 0 || row >= cells) return {0, count, count};
    const int begin{std::clamp(-first(), 0, count)};
    return {row, begin, std::clamp(cells - first(), begin, count)};
  }

  const LatticeTile& tile_;
  std::size_t k_;
  float border_;
  Antecedents from_;
};

// out(y) for the tile's rows: between the antecedents along x and y of what `fetch(y, count, out)` reads.
template <class Fetch, class Out>
HWY_INLINE void gather_rows(const LatticeTile& tile, const Antecedents& from, const Fetch& fetch, const Out& out) {
  RowBuffer raw;
  RowBuffer rows[2];
  float* here{rows[0].cells};
  float* next{rows[1].cells};
  const int columns{tile.columns()};
  const auto along_x = [&](int y, float* to) {
    if (from.fx == 0) return fetch(y, columns, to);
    fetch(y, columns + 1, raw.cells);
    blend(raw.cells, raw.cells + 1, from.fx, columns, to);
  };
  if (from.fy != 0) along_x(tile.y_begin, here);
  for (int y{tile.y_begin}; y < tile.y_end; ++y) {
    if (from.fy == 0) {
      along_x(y, out(y));
      continue;
    }
    along_x(y + 1, next);
    blend(here, next, from.fy, columns, out(y));
    std::swap(here, next);
  }
}

// Cells that have just come into the window know nothing.
void fill_new_cells(const LatticeTile& tile, int y, float value, float* row) {
  const int cells{tile.before.occupancy.width()};
  const int columns{tile.columns()};
  const bool row_known{y + tile.scroll.y >= 0 && y + tile.scroll.y < cells};
  const int first{tile.x_begin + tile.scroll.x};
  const int begin{row_known ? std::clamp(-first, 0, columns) : columns};
  const int end{row_known ? std::clamp(cells - first, begin, columns) : columns};
  std::fill(row, row + begin, value);
  std::fill(row + end, row + columns, value);
}

void PredictJoint(const LatticeTile& tile) {
  for (std::size_t k{0}; k < tile.after.velocity.size(); ++k) {
    const float prior{prior_of(tile.step, static_cast<int>(k))};
    const Source source{tile, k, tile.step.border_occupancy * prior};
    const auto row = [&](int y) { return tile.after.velocity[k].row(y) + tile.x_begin; };
    gather_rows(
        tile, source.from(), [&](int y, int count, float* out) { source.fetch(y, count, out); }, row);
    for (int y{tile.y_begin}; y < tile.y_end; ++y) fill_new_cells(tile, y, 0.5f * prior, row(y));
  }
}

void SumVelocities(const LatticeTile& tile, int y, TileSums& sums) {
  const Float df;
  const auto side = static_cast<std::size_t>(tile.step.side);
  const std::ptrdiff_t offset{tile.after.velocity[0].row(y) + tile.x_begin - tile.after.velocity[0].data()};
  for_vectors(df, tile.columns(), [&](int column, auto n) {
    auto mass = hn::Zero(df);
    auto x = hn::Zero(df);
    auto y_sum = hn::Zero(df);
    auto xx = hn::Zero(df);
    auto xy = hn::Zero(df);
    auto yy = hn::Zero(df);
    for (std::size_t row{0}; row < side * side; row += side) {
      auto row_mass = hn::Zero(df);
      auto row_x = hn::Zero(df);
      auto row_xx = hn::Zero(df);
      for (std::size_t k{row}; k < row + side; ++k) {
        const float vx{static_cast<float>(tile.tables.lattice[k].x)};
        const auto m = load(df, tile.after.velocity[k].data() + offset + column, n);
        row_mass = hn::Add(row_mass, m);
        row_x = hn::Add(row_x, hn::Mul(hn::Set(df, vx), m));
        row_xx = hn::Add(row_xx, hn::Mul(hn::Set(df, vx * vx), m));
      }
      const auto vy = hn::Set(df, static_cast<float>(tile.tables.lattice[row].y));
      mass = hn::Add(mass, row_mass);
      x = hn::Add(x, row_x);
      y_sum = hn::Add(y_sum, hn::Mul(vy, row_mass));
      xx = hn::Add(xx, row_xx);
      xy = hn::Add(xy, hn::Mul(vy, row_x));
      yy = hn::Add(yy, hn::Mul(hn::Mul(vy, vy), row_mass));
    }
    store(mass, df, sums.mass + column, n);
    store(x, df, sums.x + column, n);
    store(y_sum, df, sums.y + column, n);
    store(xx, df, sums.xx + column, n);
    store(xy, df, sums.xy + column, n);
    store(yy, df, sums.yy + column, n);
  });
}

void Rescale(const LatticeTile& tile, int y, const float* scale, const float* born) {
  const Float df;
  for (std::size_t k{0}; k < tile.after.velocity.size(); ++k) {
    float* mass{tile.after.velocity[k].row(y) + tile.x_begin};
    const auto prior = hn::Set(df, prior_of(tile.step, static_cast<int>(k)));
    for_vectors(df, tile.columns(), [&](int x, auto n) {
      const auto kept = hn::Mul(load(df, scale + x, n), load(df, mass + x, n));
      store(hn::Add(kept, hn::Mul(load(df, born + x, n), prior)), df, mass + x, n);
    });
  }
}

// Sums over the lattice's present row.
struct LatticeRowSums {
  float mass[tile_columns];
  float x[tile_columns];
  float xx[tile_columns];
};

void update_tay(const LatticeTile& tile, std::size_t k, int y, const float* occupied, TayRow& row,
                LatticeRowSums& sums) {
  const Float df;
  const float vx_mps{static_cast<float>(tile.tables.lattice[k].x)};
  const auto vx = hn::Set(df, vx_mps);
  const auto vxx = hn::Set(df, vx_mps * vx_mps);
  const bool is_standstill{static_cast<int>(k) == tile.step.standstill()};
  float* velocity{tile.after.velocity[k].row(y) + tile.x_begin};
  for_vectors(df, tile.columns(), [&](int x, auto n) {
    const auto in_cell = load(df, occupied + x, n);
    const auto beta = hn::Mul(load(df, row.likelihood_occupied + x, n), in_cell);
    const auto empty = hn::Sub(load(df, velocity + x, n), in_cell);
    const auto all = hn::Add(beta, hn::Mul(load(df, row.likelihood_empty + x, n), empty));
    store(all, df, velocity + x, n);
    store(hn::Add(load(df, row.evidence + x, n), all), df, row.evidence + x, n);
    store(hn::Add(load(df, sums.mass + x, n), beta), df, sums.mass + x, n);
    store(hn::Add(load(df, sums.x + x, n), hn::Mul(vx, beta)), df, sums.x + x, n);
    store(hn::Add(load(df, sums.xx + x, n), hn::Mul(vxx, beta)), df, sums.xx + x, n);
    if (is_standstill) store(beta, df, row.standing + x, n);
  });
}

void add_lattice_row(float vy, int columns, const LatticeRowSums& row, TileSums& sums) {
  for (int x{0}; x < columns; ++x) {
    VelocitySums cell{sums.at(x)};
    cell.add_row(vy, row.mass[x], row.x[x], row.xx[x]);
    sums.mass[x] = cell.mass;
    sums.x[x] = cell.x;
    sums.y[x] = cell.y;
    sums.xx[x] = cell.xx;
    sums.xy[x] = cell.xy;
    sums.yy[x] = cell.yy;
  }
}

// P(v_k) into after.velocity and P(occupied, v_k) into `occupied`, both predicted.
void gather_tay(const LatticeTile& tile, std::size_t k, RowBuffer* occupied) {
  const Source source{tile, k, prior_of(tile.step, static_cast<int>(k))};
  const float still_unknown{still_occupied(tile.step, 0.5f)};
  const auto fetch = [&](int y, int count, float* out) { source.fetch(y, count, out); };
  gather_rows(tile, source.from(), fetch, [&](int y) { return tile.after.velocity[k].row(y) + tile.x_begin; });
  const auto fetch_occupied = [&](int y, int count, float* out) {
    const Float df;
    RowBuffer still;
    source.fetch(y, count, out);
    source.copy(tile.after.space.still_occupied, y, count, still_unknown, still.cells);
    for_vectors(df, count, [&](int i, auto n) {
      store(hn::Mul(load(df, out + i, n), load(df, still.cells + i, n)), df, out + i, n);
    });
  };
  gather_rows(tile, source.from(), fetch_occupied, [&](int y) { return occupied[y - tile.y_begin].cells; });
}

void PredictTay(const LatticeTile& tile, TayRow* rows) {
  const auto side = static_cast<std::size_t>(tile.step.side);
  const int count{tile.y_end - tile.y_begin};
  RowBuffer occupied[tile_rows];
  LatticeRowSums of_row[tile_rows];
  for (int i{0}; i < count; ++i) {
    std::fill(rows[i].evidence, rows[i].evidence + tile_columns, 0.0f);
    rows[i].sums = {};
  }
  for (std::size_t first{0}; first < side * side; first += side) {
    std::fill(of_row, of_row + count, LatticeRowSums{});
    for (std::size_t k{first}; k < first + side; ++k) {
      gather_tay(tile, k, occupied);
      for (int i{0}; i < count; ++i) update_tay(tile, k, tile.y_begin + i, occupied[i].cells, rows[i], of_row[i]);
    }
    const float vy{static_cast<float>(tile.tables.lattice[first].y)};
    for (int i{0}; i < count; ++i) add_lattice_row(vy, tile.columns(), of_row[i], rows[i].sums);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(PredictJoint);
HWY_EXPORT(SumVelocities);
HWY_EXPORT(Rescale);
HWY_EXPORT(PredictTay);

void predict_joint(const LatticeTile& tile) {
  HWY_DYNAMIC_DISPATCH(PredictJoint)(tile);
}
void sum_velocities(const LatticeTile& tile, int y, TileSums& sums) {
  HWY_DYNAMIC_DISPATCH(SumVelocities)(tile, y, sums);
}
void rescale(const LatticeTile& tile, int y, const float* scale, const float* born) {
  HWY_DYNAMIC_DISPATCH(Rescale)(tile, y, scale, born);
}
void predict_tay(const LatticeTile& tile, TayRow* rows) {
  HWY_DYNAMIC_DISPATCH(PredictTay)(tile, rows);
}

}  // namespace stereogrid
#endif
