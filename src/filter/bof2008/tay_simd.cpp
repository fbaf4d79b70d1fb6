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
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

constexpr std::size_t lanes_max{16};
using Float = hn::CappedTag<float, lanes_max>;

// Row of cells, one more than a tile: values between two columns need both.
struct alignas(64) RowBuffer {
  float cells[tile_columns + lanes_max];
};

void blend(const float* first, const float* second, float share, int width, float* out) {
  for_shrinking_vectors(Float{}, 0, width, [&](auto d, int x) {
    hn::StoreU(between(hn::LoadU(d, first + x), hn::LoadU(d, second + x), hn::Set(d, share)), d, out + x);
  });
}

/// P(v) and P(occupied, v) of a row's cells.
struct Pair {
  float* velocity;
  float* occupied;

  [[nodiscard]] Pair next() const { return {velocity + 1, occupied + 1}; }
};

struct PairBuffer {
  RowBuffer velocity;
  RowBuffer occupied;

  [[nodiscard]] Pair pair() { return {velocity.cells, occupied.cells}; }
};

void blend(Pair first, Pair second, float share, int width, Pair out) {
  blend(first.velocity, second.velocity, share, width, out.velocity);
  blend(first.occupied, second.occupied, share, width, out.occupied);
}

// Rows of the last state, with the noise of velocity k, and the prior outside the window.
class Source {
 public:
  Source(const LatticeTile& tile, std::size_t k)
      : tile_{tile},
        k_{k},
        border_{prior_of(tile.step, static_cast<int>(k))},
        occupied_border_{border_ * still_occupied(tile.step, 0.5f)},
        from_{tile.after.space.from[k]} {}

  [[nodiscard]] const Antecedents& from() const { return from_; }

  // out[i] = column x_begin + ix + i of row y + iy, for i < count
  void fetch(int y, int count, Pair out) const {
    const FilterWorkspace& space{tile_.after.space};
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

  void fill(int begin, int end, Pair out) const {
    std::fill(out.velocity + begin, out.velocity + end, border_);
    std::fill(out.occupied + begin, out.occupied + end, occupied_border_);
  }
  template <class Velocity>
  HWY_INLINE static void take(int begin, int end, const float* still, Pair out, const Velocity& velocity) {
    for_shrinking_vectors(Float{}, begin, end, [&](auto d, int x) {
      const auto mass = velocity(d, x);
      hn::StoreU(mass, d, out.velocity + x);
      hn::StoreU(hn::Mul(mass, hn::LoadU(d, still + x)), d, out.occupied + x);
    });
  }

  const LatticeTile& tile_;
  std::size_t k_;
  float border_;
  float occupied_border_;
  Antecedents from_;
};

// P(v_k) into after.velocity and P(occupied, v_k) into `occupied`, both predicted: interpolated between the antecedents
// along x and y.
void gather(const LatticeTile& tile, std::size_t k, RowBuffer* occupied) {
  const Source source{tile, k};
  const auto [ix, iy, fx, fy] = source.from();
  PairBuffer raw;
  PairBuffer rows[2];
  Pair here{rows[0].pair()};
  Pair next{rows[1].pair()};
  const int columns{tile.columns()};
  const auto along_x = [&, fx = fx](int y, Pair to) {
    if (fx == 0) return source.fetch(y, columns, to);
    source.fetch(y, columns + 1, raw.pair());
    blend(raw.pair(), raw.pair().next(), fx, columns, to);
  };
  if (fy != 0) along_x(tile.y_begin, here);
  for (int y{tile.y_begin}; y < tile.y_end; ++y) {
    const Pair out{tile.after.velocity[k].row(y) + tile.x_begin, occupied[y - tile.y_begin].cells};
    if (fy == 0) {
      along_x(y, out);
      continue;
    }
    along_x(y + 1, next);
    blend(here, next, fy, columns, out);
    std::swap(here, next);
  }
}

// Sums over the lattice's present row.
struct RowOfLattice {
  float mass[tile_columns];
  float x[tile_columns];
  float xx[tile_columns];
  float all[tile_columns];  // tay2008: Σ l(k)
};

void update_tay(const LatticeTile& tile, float vx_mps, const float* occupied, float* velocity, const TayRow& row,
                RowOfLattice& sums) {
  for_shrinking_vectors(Float{}, 0, tile.columns(), [&](auto d, int x) {
    const auto load = [&](const float* from) { return hn::LoadU(d, from + x); };
    const auto updated =
        tay_update(load(velocity), load(occupied), load(row.likelihood_occupied), load(row.likelihood_empty));
    hn::StoreU(updated.all, d, velocity + x);
    hn::StoreU(hn::Add(load(sums.all), updated.all), d, sums.all + x);
    LatticeRowSums<hn::Vec<decltype(d)>> sum{load(sums.mass), load(sums.x), load(sums.xx)};
    sum.add(hn::Set(d, vx_mps), updated.occupied);
    hn::StoreU(sum.mass, d, sums.mass + x);
    hn::StoreU(sum.x, d, sums.x + x);
    hn::StoreU(sum.xx, d, sums.xx + x);
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

void keep_standing(const float* occupied, int columns, TayRow& row) {
  for (int x{0}; x < columns; ++x) row.standing[x] = row.likelihood_occupied[x] * occupied[x];
}

void PredictTay(const LatticeTile& tile, TayRow* rows) {
  const int count{tile.y_end - tile.y_begin};
  RowBuffer occupied[tile_rows];
  RowOfLattice of_row[tile_rows];
  for (int i{0}; i < count; ++i) {
    std::fill(rows[i].evidence, rows[i].evidence + tile_columns, 0.0f);
    rows[i].sums = {};
  }
  std::size_t k{0};
  for (const float vy_mps : tile.tables.axis_mps) {
    std::fill(of_row, of_row + count, RowOfLattice{});
    for (const float vx_mps : tile.tables.axis_mps) {
      gather(tile, k, occupied);
      for (int i{0}; i < count; ++i) {
        float* velocity{tile.after.velocity[k].row(tile.y_begin + i) + tile.x_begin};
        update_tay(tile, vx_mps, occupied[i].cells, velocity, rows[i], of_row[i]);
        if (static_cast<int>(k) == tile.step.standstill()) keep_standing(occupied[i].cells, tile.columns(), rows[i]);
      }
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
}  // namespace stereogrid::HWY_NAMESPACE
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
