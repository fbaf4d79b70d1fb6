// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; every element
// goes through the operations of model.hpp and even_model.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/joint_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                     // IWYU pragma: keep
// after foreach_target
#include "filter/joint_simd.hpp"
#include "filter/partial_vectors_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

using Float = hn::CappedTag<float, block_columns>;
using Vector = hn::Vec<Float>;

Vector set(float value) {
  return hn::Set(Float{}, value);
}

// Calls work(column) for the vectors of a row of a block.
template <class Work>
HWY_INLINE void for_block_columns(const Work& work) {
  for (int column{0}; column < block_columns; column += static_cast<int>(hn::Lanes(Float{}))) work(column);
}

void PrepareRow(const JointStep& joint, int y) {
  const FilterStep& step{joint.step};
  FilterSpace& space{joint.after.space};
  const float* const occupancy{joint.before.occupancy.row(y)};
  const float* const standing{joint.before.standing.row(y)};
  for (int x{0}; x < joint.before.occupancy.width(); ++x) {
    const float gained{gained_by_moving(step, occupancy[x], standing[x])};
    space.gained(x, y) = gained;
    space.standing(x, y) = disturbed_standing(step, occupancy[x], standing[x]);
    space.even(x, y) = disturbed(step.kept_moving, even_mass(step.each_moving, occupancy[x], standing[x]), gained);
  }
}

// Mass of each moving velocity outside the window.
float outside_of(const FilterStep& step) {
  return step.border_occupancy * step.prior_moving;
}

// to(x) += between(from(x + offset), from(x + offset + 1), share); outside of it `from` is `border`.
void add_moved(const float* from, int width, int offset, float share, float border, float* to) {
  const auto at = [&](int x) { return x >= 0 && x < width ? from[x] : border; };
  const int begin{std::clamp(-offset, 0, width)};
  const int end{std::clamp(width - 1 - offset, begin, width)};
  for (int x{0}; x < begin; ++x) to[x] += stereogrid::between(at(x + offset), at(x + offset + 1), share);
  for_shrinking_vectors(Float{}, begin, end, [&](auto d, int x) {
    const auto first = hn::LoadU(d, from + x + offset);
    const auto second = hn::LoadU(d, from + x + offset + 1);
    hn::StoreU(hn::Add(hn::LoadU(d, to + x), between(first, second, hn::Set(d, share))), d, to + x);
  });
  for (int x{end}; x < width; ++x) to[x] += stereogrid::between(at(x + offset), at(x + offset + 1), share);
}

void SpreadAlongX(const JointStep& joint, int y) {
  FilterSpace& space{joint.after.space};
  const int cells{space.even.width()};
  float* const sums{space.spread.row(y)};
  std::fill(sums, sums + cells, 0.0f);
  for (int i{0}; i < joint.step.side; ++i) {
    const Antecedents from{space.from[static_cast<std::size_t>(i)]};
    // far beyond the window all is as just beyond it
    const int offset{std::clamp(from.ix, -cells - 1, cells + 1)};
    add_moved(space.even.row(y), cells, offset, from.fx, outside_of(joint.step), sums);
  }
}

// Of a row outside the window, its sum along x.
float spread_outside(const JointStep& joint) {
  const float outside{outside_of(joint.step)};
  float sum{0};
  for (int i{0}; i < joint.step.side; ++i) {
    sum += stereogrid::between(outside, outside, joint.after.space.from[static_cast<std::size_t>(i)].fx);
  }
  return sum;
}

void ArriveEvenly(const JointStep& joint, int y, int x_begin, int x_end, float* each) {
  const FilterSpace& space{joint.after.space};
  const int cells{space.even.width()};
  const float* const here{space.even.row(y + joint.scroll.y) + joint.scroll.x};
  const float outside{spread_outside(joint)};
  for_shrinking_vectors(Float{}, x_begin, x_end, [&](auto d, int x) {
    const auto row = [&](int of) {
      return of >= 0 && of < cells ? hn::LoadU(d, space.spread.row(of) + x) : hn::Set(d, outside);
    };
    auto spread = hn::Zero(d);
    for (int j{0}; j < joint.step.side; ++j) {
      const Antecedents from{space.from[static_cast<std::size_t>(j) * static_cast<std::size_t>(joint.step.side)]};
      spread = hn::Add(spread, between(row(y + from.iy), row(y + from.iy + 1), hn::Set(d, from.fy)));
    }
    hn::StoreU(even_arrived(hn::Set(d, joint.step.each_moving), spread, hn::LoadU(d, here + x)), d, each + x - x_begin);
  });
}

// The blocks of the step before from which a block's cells get the mass of a moving velocity: two by two.
class Antecedent {
 public:
  Antecedent(const JointStep& joint, std::size_t k, int x_begin)
      : joint_{joint},
        space_{joint.after.space},
        layout_{joint.before.blocks.layout()},
        k_{k},
        first_{std::clamp(x_begin + space_.from[k].ix, -2 * block_columns, layout_.across * block_columns)} {}

  // Of the columns first … first + block_columns of row y.
  const float* row(int y, float* buffer) const {
    const int left{first_ >= 0 ? first_ / block_columns : -((block_columns - 1 - first_) / block_columns)};
    fill(left, y, buffer);
    fill(left + 1, y, buffer + block_columns);
    return buffer + (first_ - left * block_columns);
  }

 private:
  void fill(int column_of_blocks, int y, float* out) const {
    const int x{column_of_blocks * block_columns};
    const int inside{x < 0 || y < 0 || y >= layout_.cells ? 0 : std::clamp(layout_.cells - x, 0, block_columns)};
    if (inside > 0) {
      const int block{y / block_rows * layout_.across + column_of_blocks};
      const bool moves{!space_.moving[static_cast<std::size_t>(block)].is_empty()};
      const int slot{moves ? joint_.before.blocks.slot(block) : -1};
      slot >= 0 ? disturb(slot, x, y, inside, out) : copy(x, y, inside, out);
    }
    std::fill(out + inside, out + block_columns, outside_of(joint_.step));
  }

  void copy(int x, int y, int inside, float* out) const {
    const float* const even{space_.even.row(y) + x};
    if (inside < block_columns) {
      std::copy(even, even + inside, out);
    } else {
      for_block_columns([&](int i) { hn::StoreU(hn::LoadU(Float{}, even + i), Float{}, out + i); });
    }
  }

  void disturb(int slot, int x, int y, int inside, float* out) const {
    const float* const masses{joint_.before.blocks.masses(slot) + k_ * block_cells + y % block_rows * block_columns};
    const float* const gained{space_.gained.row(y) + x};
    const auto kept = [&](auto d, int i) {
      const auto share = hn::Set(d, joint_.step.kept_moving);
      hn::StoreU(disturbed(share, hn::LoadU(d, masses + i), hn::LoadU(d, gained + i)), d, out + i);
    };
    for_shrinking_vectors(Float{}, 0, inside, kept);
  }

  const JointStep& joint_;
  const FilterSpace& space_;
  const BlockLayout& layout_;
  std::size_t k_;
  int first_;
};

// Between what `row(y, buffer)` has for the rows y and y + 1 and the columns beside each other.
template <class Row>
HWY_INLINE void gather_block(const Antecedents& from, int y_begin, const Row& row, float* masses) {
  alignas(64) float buffer[2 * block_columns];
  alignas(64) float rows[block_rows + 1][block_columns];
  for (int r{0}; r <= block_rows; ++r) {
    const float* const cells{row(y_begin + r, buffer)};
    for_block_columns([&](int i) {
      const auto along_x = between(hn::LoadU(Float{}, cells + i), hn::LoadU(Float{}, cells + i + 1), set(from.fx));
      hn::Store(along_x, Float{}, rows[r] + i);
    });
  }
  for (int r{0}; r < block_rows; ++r) {
    for_block_columns([&](int i) {
      const auto mass = between(hn::Load(Float{}, rows[r] + i), hn::Load(Float{}, rows[r + 1] + i), set(from.fy));
      hn::StoreU(mass, Float{}, masses + r * block_columns + i);
    });
  }
}

// Standstill comes from one cell.
void predict_standing(const JointStep& joint, const CellBox& cells, float* masses) {
  const Image<float>& standing{joint.after.space.standing};
  for (int y{cells.y_first}; y <= cells.y_last; ++y) {
    for (int x{cells.x_first}; x <= cells.x_last; ++x) {
      const int ax{x + joint.scroll.x};
      const int ay{y + joint.scroll.y};
      const bool is_known{ax >= 0 && ax < standing.width() && ay >= 0 && ay < standing.height()};
      masses[(y - cells.y_first) * block_columns + x - cells.x_first] =
          is_known ? standing(ax, ay) : 0.5f * joint.step.prior_static;
    }
  }
}

// Cells that have just come into the window know nothing.
void fill_new_cells(const JointStep& joint, const CellBox& cells, float value, float* masses) {
  const int size{joint.before.occupancy.width()};
  for (int y{cells.y_first}; y <= cells.y_last; ++y) {
    float* const row{masses + (y - cells.y_first) * block_columns};
    const int ay{y + joint.scroll.y};
    const int columns{cells.x_last - cells.x_first + 1};
    const int first{cells.x_first + joint.scroll.x};
    const bool row_known{ay >= 0 && ay < size};
    const int begin{row_known ? std::clamp(-first, 0, columns) : columns};
    const int end{row_known ? std::clamp(size - first, begin, columns) : columns};
    std::fill(row, row + begin, value);
    std::fill(row + end, row + columns, value);
  }
}

void PredictBlock(const JointStep& joint, int block) {
  const BlockLayout& layout{joint.after.blocks.layout()};
  const CellBox cells{layout.cells_of(block)};
  float* const masses{joint.after.blocks.masses(joint.after.blocks.slot(block))};
  const std::size_t velocities{joint.after.space.from.size()};
  for (std::size_t k{0}; k < velocities; ++k) {
    float* const of_velocity{masses + k * block_cells};
    if (static_cast<int>(k) == joint.step.standstill()) {
      predict_standing(joint, cells, of_velocity);
      continue;
    }
    const Antecedents& from{joint.after.space.from[k]};
    const Antecedent antecedent{joint, k, cells.x_first};
    const int y_first{std::clamp(cells.y_first + from.iy, -block_rows - 1, layout.cells)};
    gather_block(
        from, y_first, [&](int y, float* buffer) { return antecedent.row(y, buffer); }, of_velocity);
    fill_new_cells(joint, cells, 0.5f * joint.step.prior_moving, of_velocity);
  }
}

void SumRow(const FilterTables& tables, const float* masses, BlockRowSums& sums) {
  for_block_columns([&](int column) {
    LatticeSums<Vector> sum;
    const float* of_velocity{masses + column};
    for (const float vy_mps : tables.axis_mps) {
      LatticeRowSums<Vector> row;
      for (const float vx_mps : tables.axis_mps) {
        row.add(set(vx_mps), hn::LoadU(Float{}, of_velocity));
        of_velocity += block_cells;
      }
      sum.add(set(vy_mps), row);
    }
    hn::StoreU(sum.mass, Float{}, sums.mass + column);
    hn::StoreU(sum.x, Float{}, sums.x + column);
    hn::StoreU(sum.y, Float{}, sums.y + column);
    hn::StoreU(sum.xx, Float{}, sums.xx + column);
    hn::StoreU(sum.xy, Float{}, sums.xy + column);
    hn::StoreU(sum.yy, Float{}, sums.yy + column);
  });
}

void RescaleRow(const FilterStep& step, const float* scale, const float* born_moving, const float* born_standing,
                float* masses) {
  for (int k{0}; k < step.velocities(); ++k) {
    const float* const born{k == step.standstill() ? born_standing : born_moving};
    float* const of_velocity{masses + static_cast<std::ptrdiff_t>(k) * block_cells};
    for_block_columns([&](int i) {
      const auto kept = hn::Mul(hn::LoadU(Float{}, scale + i), hn::LoadU(Float{}, of_velocity + i));
      hn::StoreU(hn::Add(kept, hn::LoadU(Float{}, born + i)), Float{}, of_velocity + i);
    });
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(PrepareRow);
HWY_EXPORT(SpreadAlongX);
HWY_EXPORT(ArriveEvenly);
HWY_EXPORT(PredictBlock);
HWY_EXPORT(SumRow);
HWY_EXPORT(RescaleRow);

void prepare_row(const JointStep& joint, int y) {
  HWY_DYNAMIC_DISPATCH(PrepareRow)(joint, y);
}
void spread_along_x(const JointStep& joint, int y) {
  HWY_DYNAMIC_DISPATCH(SpreadAlongX)(joint, y);
}
void arrive_evenly(const JointStep& joint, int y, int x_begin, int x_end, float* each) {
  HWY_DYNAMIC_DISPATCH(ArriveEvenly)(joint, y, x_begin, x_end, each);
}
void predict_block(const JointStep& joint, int block) {
  HWY_DYNAMIC_DISPATCH(PredictBlock)(joint, block);
}
void sum_row(const FilterTables& tables, const float* masses, BlockRowSums& sums) {
  HWY_DYNAMIC_DISPATCH(SumRow)(tables, masses, sums);
}
void rescale_row(const FilterStep& step, const float* scale, const float* born_moving, const float* born_standing,
                 float* masses) {
  HWY_DYNAMIC_DISPATCH(RescaleRow)(step, scale, born_moving, born_standing, masses);
}

}  // namespace stereogrid
#endif
