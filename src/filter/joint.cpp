// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/forms.hpp"

#include <algorithm>
#include <limits>

#include "backend/cpu.hpp"
#include "filter/joint_simd.hpp"

namespace stereogrid {
namespace {

// Blocks of the window through the filter.
class BlockFilter {
 public:
  BlockFilter(const FilterInput& input, View<const float> observed, const JointStep& joint, GridLayers& layers)
      : input_{input}, observed_{observed}, joint_{joint}, layout_{joint.after.blocks.layout()}, layers_{layers} {}

  void run(int block) const {
    const CellBox cells{layout_.cells_of(block)};
    const int slot{joint_.after.blocks.slot(block)};
    if (slot >= 0) predict_block(joint_, block);
    for (int y{cells.y_first}; y <= cells.y_last; ++y) {
      if (slot < 0) {
        run_even_row(cells, y);
      } else {
        run_row(cells, y, joint_.after.blocks.masses(slot) + (y - cells.y_first) * block_columns);
      }
    }
  }

 private:
  void run_row(const CellBox& cells, int y, float* masses) const {
    BlockRowSums sums;
    sum_row(joint_.tables, masses, sums);
    float scale[block_columns]{};
    float born_moving[block_columns]{};
    float born_standing[block_columns]{};
    const float* const standing{masses + joint_.step.standstill() * block_cells};
    for (int x{cells.x_first}; x <= cells.x_last; ++x) {
      const int i{x - cells.x_first};
      const JointUpdate update{
          joint_update(joint_.step, sums.mass[i], age_before(x, y), likelihood_at(x, y), view_of(joint_.step, x, y))};
      scale[i] = update.scale;
      born_moving[i] = update.born_moving;
      born_standing[i] = update.born_standing;
      write({update.occupancy, update.scale * standing[i] + update.born_standing,
             updated(joint_.step, update, sums.at(i))},
            x, y);
    }
    rescale_row(joint_.step, scale, born_moving, born_standing, masses);
  }

  void run_even_row(const CellBox& cells, int y) const {
    const int size{layout_.cells};
    const bool row_known{y + joint_.scroll.y >= 0 && y + joint_.scroll.y < size};
    const int end{cells.x_last + 1};
    const int known_begin{row_known ? std::clamp(-joint_.scroll.x, cells.x_first, end) : end};
    const int known_end{row_known ? std::clamp(size - joint_.scroll.x, known_begin, end) : end};
    float each[block_columns];
    arrive_evenly(joint_, y, known_begin, known_end, each);
    for (int x{cells.x_first}; x < end; ++x) {
      const bool is_known{x >= known_begin && x < known_end};
      const EvenArrived arrived{is_known ? EvenArrived{standing_before(x, y), each[x - known_begin]}
                                         : new_to_the_window(joint_.step)};
      write(updated_evenly(joint_.step, arrived, age_before(x, y), likelihood_at(x, y), view_of(joint_.step, x, y)), x,
            y);
    }
  }

  [[nodiscard]] float standing_before(int x, int y) const {
    return joint_.after.space.standing(x + joint_.scroll.x, y + joint_.scroll.y);
  }

  [[nodiscard]] Likelihood likelihood_at(int x, int y) const {
    return likelihood_of(input_.tables.likelihood.data(), observed_(x, y));
  }

  [[nodiscard]] float age_before(int x, int y) const {
    return stereogrid::age_before(joint_.before.age_s, joint_.scroll, x, y);
  }

  void write(const FilteredCell& cell, int x, int y) const {
    FilterState& after{joint_.after};
    after.occupancy(x, y) = layers_.occupancy(x, y) = cell.occupancy;
    after.standing(x, y) = cell.standing;
    const float age_s{is_known(observed_(x, y)) ? 0.0f : age_before(x, y) + static_cast<float>(input_.dt_s)};
    after.age_s(x, y) = layers_.age_s(x, y) = age_s;
    layers_.moving(x, y) = moving_share(cell.occupancy, cell.standing);
    write_velocity(estimate_of(cell.sums), x, y, layers_);
  }

  const FilterInput& input_;
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
        joint.before.moving_cells(joint.step.moving_mass_min, block);
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
  const JointStep joint{step, input.tables, before, after, scroll_between(before.geometry, input.geometry)};
  set_antecedents(input, joint.scroll, after.space.from);
  const BlockLayout& layout{after.blocks.layout()};
  cpu.for_ranges(layout.along, 1, [&](int begin, int end) {
    for (int row{begin}; row < end; ++row) prepare(joint, row);
  });
  after.blocks.begin(step, joint.scroll, after.space.moving);
  const BlockFilter blocks{input, observed, joint, layers};
  cpu.for_ranges(layout.count(), 1, [&](int begin, int end) {
    for (int block{begin}; block < end; ++block) blocks.run(block);
  });
}

}  // namespace stereogrid
