// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "backend/cpu.hpp"
#include "filter/forms.hpp"
#include "filter/joint/joint_simd.hpp"

namespace stereogrid {
namespace {

// Blocks of the window through the filter.
class BlockFilter {
 public:
  BlockFilter(const FilterInput& input, View<const float> observed, const JointStep& joint, GridLayers& layers)
      : kinds_before_{input.kinds_before},
        observed_{observed},
        joint_{joint},
        layout_{joint.after.blocks.layout()},
        layers_{layers} {}

  // One that has masses.
  void run(int block) const {
    const CellBox cells{layout_.cells_of(block)};
    joint_.after.kinds[static_cast<std::size_t>(block)] = BlockKind::any;
    predict_block(joint_, block);
    float* masses{joint_.after.blocks.masses(joint_.after.blocks.slot(block))};
    for (int y{cells.y_first}; y <= cells.y_last; ++y, masses += block_columns) {
      run(row_of(block, cells.x_first, y), masses);
    }
  }

  // Processes a row of active blocks without masses, row by row through all of them, for sequential memory access.
  void run_even(int block_row) const {
    const int first{block_row * layout_.across};
    BlockKind* const kinds{joint_.after.kinds.data() + first};
    for (int i{0}; i < layout_.across; ++i) {
      const bool has_masses{joint_.after.blocks.slot(first + i) >= 0};
      if (!has_masses && joint_.after.space.active.is_active(first + i)) kinds[i] = BlockKind::even;
    }
    const CellBox cells{layout_.cells_of(first)};
    for (int y{cells.y_first}; y <= cells.y_last; ++y) {
      for (int i{0}; i < layout_.across; ++i) {
        if (kinds[i] == BlockKind::even) run(row_of(first + i, i * block_columns, y), nullptr);
      }
    }
  }

 private:
  // Row of a block whose first column is x.
  [[nodiscard]] BlockRow row_of(int block, int x, int y) const {
    BlockRow row;
    row.was_even = kinds_before_ != nullptr && (*kinds_before_)[static_cast<std::size_t>(block)] != BlockKind::any;
    row.x = x;
    row.y = y;
    row.columns = std::min(block_columns, layout_.cells - x);
    return row;
  }

  // `masses`: of the first velocity; null: the block has none.
  void run(BlockRow row, float* masses) const {
    const CellColumns known{known_columns(joint_, row.x, row.y, row.columns)};
    take(known, row);
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

  // Reads the last state of the row where it was in the window; new cells have the prior.
  void take(CellColumns known, BlockRow& row) const {
    const int y{row.y + joint_.scroll.y};
    const int first{row.x + joint_.scroll.x};
    if (known.begin == 0 && known.end == row.columns) return take_before(joint_, row);
    const EvenArrived is_new{new_to_the_window(joint_.step)};
    std::fill_n(row.each, row.columns, is_new.each);
    std::fill_n(row.age_s, row.columns, std::numeric_limits<float>::infinity());
    std::fill_n(row.standing, row.columns, is_new.standing);
    std::fill_n(row.unseen, row.columns, 1.0f);
    for (int i{known.begin}; i < known.end; ++i) {
      row.age_s[i] = joint_.before.age_s(first + i, y);
      row.standing[i] = joint_.after.space.standing(first + i, y);
      row.unseen[i] = joint_.before.is_as_unseen(joint_.step, first + i, y) ? 1.0f : 0.0f;
    }
  }

  const std::vector<BlockKind>* kinds_before_;
  View<const float> observed_;
  const JointStep& joint_;
  const BlockLayout& layout_;
  GridLayers& layers_;
};

// Copies blocks that need no step.
class UnseenBlocks {
 public:
  UnseenBlocks(const FilterInput& input, const JointStep& joint, GridLayers& layers)
      : kinds_before_{input.kinds_before},
        state_{joint.after},
        layers_{layers},
        cell_{unseen_cell(joint.step, 0.0f)},
        velocity_{estimate_of(cell_.sums)} {}

  void write(int block) const {
    const CellBox cells{state_.blocks.layout().cells_of(block)};
    const auto i = static_cast<std::size_t>(block);
    if (!state_.is_unseen(block)) write_state(cells);
    state_.kinds[i] = BlockKind::unseen;
    if (kinds_before_ == nullptr || (*kinds_before_)[i] != BlockKind::unseen) write_layers(cells);
  }

 private:
  void write_state(const CellBox& cells) const {
    fill(cells, cell_.occupancy, state_.occupancy);
    fill(cells, cell_.standing, state_.standing);
    fill(cells, std::numeric_limits<float>::infinity(), state_.age_s);
  }

  void write_layers(const CellBox& cells) const {
    fill(cells, cell_.occupancy, layers_.occupancy);
    fill(cells, moving_share(cell_.occupancy, cell_.standing), layers_.moving);
    fill(cells, std::numeric_limits<float>::infinity(), layers_.age_s);
    fill(cells, velocity_.x, layers_.velocity_x);
    fill(cells, velocity_.y, layers_.velocity_y);
    fill(cells, velocity_.xx, layers_.velocity_xx);
    fill(cells, velocity_.xy, layers_.velocity_xy);
    fill(cells, velocity_.yy, layers_.velocity_yy);
  }

  static void fill(const CellBox& cells, float value, Image<float>& image) {
    for (int y{cells.y_first}; y <= cells.y_last; ++y) {
      std::fill(image.row(y) + cells.x_first, image.row(y) + cells.x_last + 1, value);
    }
  }

  const std::vector<BlockKind>* kinds_before_;
  FilterState& state_;
  GridLayers& layers_;
  FilteredCell cell_;
  VelocityEstimate velocity_;
};

// A row of blocks of the step before, as far as something is read of it.
void prepare(const JointStep& joint, int row) {
  const BlockLayout& layout{joint.before.blocks.layout()};
  const CellColumns reached{joint.after.space.active.reached_columns(row, joint.step, joint.scroll)};
  if (reached.is_empty()) return;
  const int around{joint.step.reach + 1};
  const CellColumns read{std::clamp(reached.begin + joint.scroll.x - around, 0, layout.cells),
                         std::clamp(reached.end + joint.scroll.x + around, 0, layout.cells)};
  for (int y{row * block_rows}; y < std::min((row + 1) * block_rows, layout.cells); ++y) {
    prepare_row(joint, y, read);
    spread_along_x(joint, y, reached);
  }
}

// All rows of blocks, each on one thread.
template <class Work>
void for_block_rows(Cpu& cpu, const BlockLayout& layout, const Work& work) {
  cpu.for_ranges(layout.along, 1, [&](int begin, int end) {
    for (int row{begin}; row < end; ++row) work(row);
  });
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
  for_block_rows(cpu, layout, [&](int row) { find_cells(joint, row); });
  after.blocks.begin(step, joint.scroll, after.space.moving);
  const auto has_some = [&](int block) {
    return after.blocks.slot(block) >= 0 || is_any_observed(observed, layout.cells_of(block));
  };
  for_block_rows(cpu, layout, [&](int row) { after.space.active.decide(row, joint.scroll, has_some); });
  for_block_rows(cpu, layout, [&](int row) { prepare(joint, row); });
  const BlockFilter active{input, observed, joint, layers};
  const UnseenBlocks unseen{input, joint, layers};
  cpu.for_ranges(layout.count(), 1, [&](int begin, int end) {
    for (int block{begin}; block < end; ++block) {
      if (!after.space.active.is_active(block)) {
        unseen.write(block);
      } else if (after.blocks.slot(block) >= 0) {
        active.run(block);
      }
    }
  });
  for_block_rows(cpu, layout, [&](int row) { active.run_even(row); });
}

}  // namespace stereogrid
