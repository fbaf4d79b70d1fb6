// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "backend/cpu.hpp"
#include "filter/forms.hpp"
#include "filter/joint_simd.hpp"

namespace stereogrid {
namespace {

// Blocks of the window through the filter.
class BlockFilter {
 public:
  BlockFilter(View<const float> observed, const JointStep& joint, GridLayers& layers)
      : observed_{observed}, joint_{joint}, layout_{joint.after.blocks.layout()}, layers_{layers} {}

  void run(int block) const {
    const CellBox cells{layout_.cells_of(block)};
    const int slot{joint_.after.blocks.slot(block)};
    if (slot >= 0) predict_block(joint_, block);
    BlockRow row{};
    row.x = cells.x_first;
    row.columns = cells.x_last - cells.x_first + 1;
    for (row.y = cells.y_first; row.y <= cells.y_last; ++row.y) {
      float* const masses{slot < 0 ? nullptr
                                   : joint_.after.blocks.masses(slot) + (row.y - cells.y_first) * block_columns};
      run(row, masses);
    }
  }

 private:
  // `masses`: of the first velocity; null: the block has none.
  void run(BlockRow& row, float* masses) const {
    const ColumnRange known{known_columns(joint_, row.x, row.y, row.columns)};
    take_before(known, row);
    if (masses == nullptr) {
      arrive_evenly(joint_, known, row);
      update_row(joint_, observed_, nullptr, row, layers_);
      return;
    }
    BlockRowSums sums;
    sum_row(joint_.tables, masses, sums);
    update_row(joint_, observed_, &sums, row, layers_);
    rescale_row(joint_.step, row, masses);
  }

  // What the step before has left of the row, where it was in the window, and what a new cell has.
  void take_before(ColumnRange known, BlockRow& row) const {
    const int y{row.y + joint_.scroll.y};
    const int first{row.x + joint_.scroll.x};
    const EvenArrived is_new{new_to_the_window(joint_.step)};
    for (int i{0}; i < row.columns; ++i) {
      const bool is_known{i >= known.begin && i < known.end};
      row.age_s[i] = is_known ? joint_.before.age_s(first + i, y) : std::numeric_limits<float>::infinity();
      row.standing[i] = is_known ? joint_.after.space.standing(first + i, y) : is_new.standing;
      row.each[i] = is_new.each;
    }
  }

  View<const float> observed_;
  const JointStep& joint_;
  const BlockLayout& layout_;
  GridLayers& layers_;
};

// A row of blocks of the step before.
void prepare(const JointStep& joint, int row) {
  const BlockLayout& layout{joint.before.blocks.layout()};
  for (int i{0}; i < layout.across; ++i) {
    const int block{row * layout.across + i};
    joint.after.space.moving[static_cast<std::size_t>(block)] =
        joint.before.moving_cells(joint.step.moving_from, block);
  }
  for (int y{row * block_rows}; y < std::min((row + 1) * block_rows, layout.cells); ++y) {
    prepare_row(joint, y);
    spread_along_x(joint, y);
  }
}

}  // namespace

void filter_joint(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                  FilterState& after, GridLayers& layers) {
  const FilterStep step{step_of(input)};
  const JointStep joint{step,
                        input.tables,
                        before,
                        after,
                        scroll_between(before.geometry, input.geometry),
                        static_cast<float>(input.dt_s)};
  set_antecedents(input, joint.scroll, after.space.from);
  const BlockLayout& layout{after.blocks.layout()};
  cpu.for_ranges(layout.along, 1, [&](int begin, int end) {
    for (int row{begin}; row < end; ++row) prepare(joint, row);
  });
  after.blocks.begin(step, joint.scroll, after.space.moving);
  const BlockFilter blocks{observed, joint, layers};
  cpu.for_ranges(layout.count(), 1, [&](int begin, int end) {
    for (int block{begin}; block < end; ++block) blocks.run(block);
  });
}

}  // namespace stereogrid
