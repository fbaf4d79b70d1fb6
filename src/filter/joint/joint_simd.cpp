// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; every element
// goes through the operations of model.hpp and even_model.hpp in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/joint/joint_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                           // IWYU pragma: keep
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
void PrepareRow(const JointStep& joint, int y, CellColumns columns) {
  const FilterStep& step{joint.step};
  FilterWorkspace& space{joint.after.space};
  for_shrinking_vectors(Float{}, columns.begin, columns.end, [&](auto d, int x) {
    const auto occupancy = hn::LoadU(d, joint.before.occupancy.row(y) + x);
    const auto standing = hn::LoadU(d, joint.before.standing.row(y) + x);
    const auto gained = (gained_by_moving)(step, occupancy, standing);
    const auto even = (even_mass)(step.each_moving, occupancy, standing);
    hn::StoreU(gained, d, space.gained.row(y) + x);
    hn::StoreU((disturbed_standing)(step, occupancy, standing), d, space.standing.row(y) + x);
    hn::StoreU(disturbed(hn::Set(d, step.kept_moving), even, gained), d, space.even.row(y) + x);
  });
}

// to(x) += between(from(x + offset), from(x + offset + 1), share) in some columns; outside of it `from` is `border`.
void add_moved(const float* from, int width, int offset, float share, float border, CellColumns columns, float* to) {
  const auto at = [&](int x) { return x >= 0 && x < width ? from[x] : border; };
  const int begin{std::clamp(-offset, columns.begin, columns.end)};
  const int end{std::clamp(width - 1 - offset, begin, columns.end)};
  for (int x{columns.begin}; x < begin; ++x) to[x] += stereogrid::between(at(x + offset), at(x + offset + 1), share);
  for_shrinking_vectors(Float{}, begin, end, [&](auto d, int x) {
    const auto first = hn::LoadU(d, from + x + offset);
    const auto second = hn::LoadU(d, from + x + offset + 1);
    hn::StoreU(hn::Add(hn::LoadU(d, to + x), between(first, second, hn::Set(d, share))), d, to + x);
  });
  for (int x{end}; x < columns.end; ++x) to[x] += stereogrid::between(at(x + offset), at(x + offset + 1), share);
}

void SpreadAlongX(const JointStep& joint, int y, CellColumns columns) {
  FilterWorkspace& space{joint.after.space};
  const int cells{space.even.width()};
  float* const sums{space.spread.row(y)};
  std::fill(sums + columns.begin, sums + columns.end, 0.0f);
  for (int i{0}; i < joint.step.side; ++i) {
    const Antecedents from{space.from[static_cast<std::size_t>(i)]};
    // far beyond the window all is as just beyond it
    const int offset{std::clamp(from.ix, -cells - 1, cells + 1)};
    add_moved(space.even.row(y), cells, offset, from.fx, even_outside(joint.step), columns, sums);
  }
}

// Spread mass of a row outside the window, its sum along x.
float spread_outside(const JointStep& joint) {
  const float outside{even_outside(joint.step)};
  float sum{0};
  for (int i{0}; i < joint.step.side; ++i) {
    sum += stereogrid::between(outside, outside, joint.after.space.from[static_cast<std::size_t>(i)].fx);
  }
  return sum;
}

constexpr int lanes{hn::MaxLanes(Float{})};

// Antecedents of the lattice's row of v_y.
const Antecedents& antecedents_of_row(const JointStep& joint, int row) {
  return joint.after.space.from[static_cast<std::size_t>(row) * static_cast<std::size_t>(joint.step.side)];
}

// The antecedents of all velocities lie in the window. They ascend or descend with v_y.
bool are_inside(const JointStep& joint, int y) {
  const int first{y + antecedents_of_row(joint, 0).iy};
  const int last{y + antecedents_of_row(joint, joint.step.side - 1).iy};
  return std::min(first, last) >= 0 && std::max(first, last) + 1 < joint.after.space.even.width();
}

// All columns of a row, whose antecedents are inside: each velocity's rows are looked up once.
void ArriveInside(const JointStep& joint, const float* before, BlockRow& cells) {
  constexpr int vectors{block_columns / lanes};
  const Float d;
  const FilterWorkspace& space{joint.after.space};
  hn::Vec<Float> spread[vectors];
  for (auto& sum : spread) sum = hn::Zero(d);
  for (int j{0}; j < joint.step.side; ++j) {
    const Antecedents& from{antecedents_of_row(joint, j)};
    const float* const row{space.spread.row(cells.y + from.iy) + cells.x};
    const float* const next{row + space.spread.width()};
    const auto share = hn::Set(d, from.fy);
    for (int v{0}; v < vectors; ++v) {
      spread[v] = hn::Add(spread[v], between(hn::LoadU(d, row + v * lanes), hn::LoadU(d, next + v * lanes), share));
    }
  }
  for (int v{0}; v < vectors; ++v) {
    const auto here = hn::LoadU(d, before + v * lanes);
    hn::StoreU(even_arrived(hn::Set(d, joint.step.each_moving), spread[v], here), d, cells.each + v * lanes);
  }
}

void ArriveEvenly(const JointStep& joint, CellColumns columns, BlockRow& cells) {
  if (columns.begin == columns.end) return;
  const FilterWorkspace& space{joint.after.space};
  const int size{space.even.width()};
  const float* const before{space.even.row(cells.y + joint.scroll.y)};
  if (columns.end - columns.begin == block_columns && are_inside(joint, cells.y)) {
    return ArriveInside(joint, before + (cells.x + joint.scroll.x), cells);
  }
  for_shrinking_vectors(Float{}, columns.begin, columns.end, [&](auto d, int i) {
    const auto row = [&](int y) {
      const bool is_inside{y >= 0 && y < size};
      return is_inside ? hn::LoadU(d, space.spread.row(y) + cells.x + i) : hn::Set(d, spread_outside(joint));
    };
    auto spread = hn::Zero(d);
    for (int j{0}; j < joint.step.side; ++j) {
      const Antecedents& from{antecedents_of_row(joint, j)};
      spread = hn::Add(spread, between(row(cells.y + from.iy), row(cells.y + from.iy + 1), hn::Set(d, from.fy)));
    }
    const auto here = hn::LoadU(d, before + (cells.x + joint.scroll.x + i));
    const auto each = even_arrived(hn::Set(d, joint.step.each_moving), spread, here);
    hn::StoreU(each, d, cells.each + i);
  });
}

// Quotient that rounds down.
int floor_of(int numerator, int denominator) {
  return numerator >= 0 ? numerator / denominator : -((denominator - 1 - numerator) / denominator);
}

// The cells of the step before from which a block gets the mass of a moving velocity: block_columns + 1 columns from x
// on and block_rows + 1 rows from y on. They lie in up to two by two blocks.
class Antecedent {
 public:
  static constexpr int rows{block_rows + 1};
  static constexpr int pitch{2 * block_columns};

  Antecedent(const JointStep& joint, std::size_t k, int x, int y)
      : joint_{joint},
        space_{joint.after.space},
        cells_{joint.before.blocks.layout().cells},
        x_{x},
        y_{y},
        left_{floor_of(x, block_columns)},
        top_{floor_of(y, block_rows)} {
    const bool is_inside{x >= 0 && y >= 0 && x + block_columns < cells_ && y + block_rows < cells_};
    is_even_ = is_inside;
    for (int i{0}; i < 4; ++i) {
      masses_[i] = masses_of(k, left_ + i % 2, top_ + i / 2);
      is_even_ = is_even_ && masses_[i] == nullptr;
    }
  }

  // Some have the masses of an image's cells.
  [[nodiscard]] View<const float> cells(float* buffer) const {
    if (is_even_) return {space_.even.row(y_) + x_, block_columns + 1, rows, space_.even.width()};
    const int first{x_ - left_ * block_columns};
    for (int i{0}; i < 4; ++i) {
      const int begin{i < 2 ? y_ : (top_ + 1) * block_rows};
      const int end{i < 2 ? (top_ + 1) * block_rows : y_ + rows};
      // whole vectors
      const CellColumns needed{i % 2 == 0 ? CellColumns{first / lanes * lanes, block_columns}
                                          : CellColumns{0, std::min(first / lanes * lanes + lanes, block_columns)}};
      const int block_x{left_ + i % 2};
      float* const out{buffer + (begin - y_) * pitch + i % 2 * block_columns};
      if (is_inside(block_x, begin, end)) {
        fill(block_x, begin, end, masses_[i], needed, out);
      } else {
        for (int y{begin}; y < end; ++y) fill_at_border(block_x, y, masses_[i], out + (y - begin) * pitch);
      }
    }
    return {buffer + first, block_columns + 1, rows, pitch};
  }

 private:
  // Null: the block's dynamic mass is spread evenly, or it lies outside the window.
  [[nodiscard]] const float* masses_of(std::size_t k, int block_x, int block_y) const {
    const BlockLayout& layout{joint_.before.blocks.layout()};
    if (block_x < 0 || block_x >= layout.across || block_y < 0 || block_y >= layout.along) return nullptr;
    const int block{block_y * layout.across + block_x};
    const bool moves{!space_.moving[static_cast<std::size_t>(block)].is_empty()};
    const int slot{moves ? joint_.before.blocks.slot(block) : -1};
    return slot >= 0 ? joint_.before.blocks.masses(slot) + k * block_cells : nullptr;
  }

  // Rows of a block, all of whose columns are in the window.
  [[nodiscard]] bool is_inside(int block_x, int begin, int end) const {
    return block_x >= 0 && (block_x + 1) * block_columns <= cells_ && begin >= 0 && end <= cells_;
  }

  void fill(int block_x, int begin, int end, const float* masses, CellColumns needed, float* out) const {
    const Float d;
    const auto kept = hn::Set(d, joint_.step.kept_moving);
    const float* even{space_.even.row(begin) + block_x * block_columns};
    const float* gained{space_.gained.row(begin) + block_x * block_columns};
    if (masses != nullptr) masses += begin % block_rows * block_columns;
    for (int y{begin}; y < end; ++y, out += pitch, even += space_.even.width(), gained += space_.gained.width()) {
      for (int i{needed.begin}; i < needed.end; i += lanes) {
        const auto mass = masses == nullptr ? hn::LoadU(d, even + i)
                                            : disturbed(kept, hn::LoadU(d, masses + i), hn::LoadU(d, gained + i));
        hn::StoreU(mass, d, out + i);
      }
      if (masses != nullptr) masses += block_columns;
    }
  }

  void fill_at_border(int block_x, int y, const float* masses, float* out) const {
    const int x{block_x * block_columns};
    const int inside{x < 0 || y < 0 || y >= cells_ ? 0 : std::clamp(cells_ - x, 0, block_columns)};
    for_shrinking_vectors(Float{}, 0, inside, [&](auto d, int i) {
      const auto even = hn::LoadU(d, space_.even.row(y) + x + i);
      hn::StoreU(masses == nullptr ? even
                                   : disturbed(hn::Set(d, joint_.step.kept_moving),
                                               hn::LoadU(d, masses + y % block_rows * block_columns + i),
                                               hn::LoadU(d, space_.gained.row(y) + x + i)),
                 d, out + i);
    });
    std::fill(out + inside, out + block_columns, even_outside(joint_.step));
  }

  const JointStep& joint_;
  const FilterWorkspace& space_;
  int cells_;
  int x_;
  int y_;
  int left_;
  int top_;
  bool is_even_{true};
  const float* masses_[4];
};

// Between cells beside each other.
void gather_block(const Antecedents& from, View<const float> cells, float* masses) {
  const Float d;
  const auto x_share = hn::Set(d, from.fx);
  const auto y_share = hn::Set(d, from.fy);
  for (int i{0}; i < block_columns; i += lanes) {
    const auto along_x = [&](int row) {
      return between(hn::LoadU(d, cells.row(row) + i), hn::LoadU(d, cells.row(row) + i + 1), x_share);
    };
    auto above = along_x(0);
    for (int row{0}; row < block_rows; ++row) {
      const auto below = along_x(row + 1);
      hn::StoreU(between(above, below, y_share), d, masses + row * block_columns + i);
      above = below;
    }
  }
}

// Standstill comes from one cell.
void predict_standing(const JointStep& joint, const CellBox& cells, float* masses) {
  for (int y{cells.y_first}; y <= cells.y_last; ++y) {
    float* const row{masses + (y - cells.y_first) * block_columns};
    const int columns{cells.x_last - cells.x_first + 1};
    const CellColumns known{known_columns(joint, cells.x_first, y, columns)};
    std::fill(row, row + columns, new_to_the_window(joint.step).standing);
    for (int i{known.begin}; i < known.end; ++i) {
      row[i] = joint.after.space.standing(cells.x_first + i + joint.scroll.x, y + joint.scroll.y);
    }
  }
}

bool has_new_cells(const JointStep& joint, const CellBox& cells) {
  const int x{cells.x_first + joint.scroll.x};
  const int y{cells.y_first + joint.scroll.y};
  const int size{joint.before.occupancy.width()};
  return x < 0 || y < 0 || x + block_columns > size || y + block_rows > size;
}

// Cells that have just come into the window know nothing.
void fill_new_cells(const JointStep& joint, const CellBox& cells, float* masses) {
  const float value{new_to_the_window(joint.step).each};
  for (int y{cells.y_first}; y <= cells.y_last; ++y) {
    float* const row{masses + (y - cells.y_first) * block_columns};
    const int columns{cells.x_last - cells.x_first + 1};
    const CellColumns known{known_columns(joint, cells.x_first, y, columns)};
    std::fill(row, row + known.begin, value);
    std::fill(row + known.end, row + columns, value);
  }
}

void PredictBlock(const JointStep& joint, int block) {
  const BlockLayout& layout{joint.after.blocks.layout()};
  const CellBox cells{layout.cells_of(block)};
  float* const masses{joint.after.blocks.masses(joint.after.blocks.slot(block))};
  const std::size_t velocities{joint.after.space.from.size()};
  const bool has_new{has_new_cells(joint, cells)};
  alignas(64) float buffer[Antecedent::rows * Antecedent::pitch];
  for (std::size_t k{0}; k < velocities; ++k) {
    float* const of_velocity{masses + k * block_cells};
    if (static_cast<int>(k) == joint.step.standstill()) {
      predict_standing(joint, cells, of_velocity);
      continue;
    }
    const Antecedents& from{joint.after.space.from[k]};
    // far beyond the window all is as just beyond it
    const int x_first{std::clamp(cells.x_first + from.ix, -2 * block_columns, layout.cells + block_columns)};
    const int y_first{std::clamp(cells.y_first + from.iy, -2 * block_rows, layout.cells + block_rows)};
    gather_block(from, Antecedent{joint, k, x_first, y_first}.cells(buffer), of_velocity);
    if (has_new) fill_new_cells(joint, cells, of_velocity);
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(PrepareRow);
HWY_EXPORT(SpreadAlongX);
HWY_EXPORT(ArriveEvenly);
HWY_EXPORT(PredictBlock);

void prepare_row(const JointStep& joint, int y, CellColumns columns) {
  HWY_DYNAMIC_DISPATCH(PrepareRow)(joint, y, columns);
}
void spread_along_x(const JointStep& joint, int y, CellColumns columns) {
  HWY_DYNAMIC_DISPATCH(SpreadAlongX)(joint, y, columns);
}
void arrive_evenly(const JointStep& joint, CellColumns columns, BlockRow& row) {
  HWY_DYNAMIC_DISPATCH(ArriveEvenly)(joint, columns, row);
}
void predict_block(const JointStep& joint, int block) {
  HWY_DYNAMIC_DISPATCH(PredictBlock)(joint, block);
}

}  // namespace stereogrid
#endif
