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
  BlockFilter(const FilterInput& input, View<const float> observed, const JointStep& joint, GridLayers& layers)
      : kinds_before_{input.kinds_before},
        observed_{observed},
        joint_{joint},
        layout_{joint.after.blocks.layout()},
        layers_{layers} {}

  void run(int block) const {
    const CellBox cells{layout_.cells_of(block)};
    const int slot{joint_.after.blocks.slot(block)};
    const auto i = static_cast<std::size_t>(block);
    joint_.after.kinds[i] = slot < 0 ? BlockKind::even : BlockKind::any;
    if (slot >= 0) predict_block(joint_, block);
    BlockRow row{};
    row.was_even = kinds_before_ != nullptr && (*kinds_before_)[i] != BlockKind::any;
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
    const CellColumns known{known_columns(joint_, row.x, row.y, row.columns)};
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
  void take_before(CellColumns known, BlockRow& row) const {
    const int y{row.y + joint_.scroll.y};
    const int first{row.x + joint_.scroll.x};
    const EvenArrived is_new{new_to_the_window(joint_.step)};
    std::fill_n(row.each, row.columns, is_new.each);
    if (known.begin > 0 || known.end < row.columns) {
      std::fill_n(row.age_s, row.columns, std::numeric_limits<float>::infinity());
      std::fill_n(row.standing, row.columns, is_new.standing);
      std::fill_n(row.unseen, row.columns, 1.0f);
    }
    if (known.is_empty()) return;
    const int x{first + known.begin};
    const int count{known.end - known.begin};
    std::copy_n(joint_.before.age_s.row(y) + x, count, row.age_s + known.begin);
    std::copy_n(joint_.after.space.standing.row(y) + x, count, row.standing + known.begin);
    for (int i{0}; i < count; ++i)
      row.unseen[known.begin + i] = joint_.before.is_as_unseen(joint_.step, x + i, y) ? 1.0f : 0.0f;
  }

  const std::vector<BlockKind>* kinds_before_;
  View<const float> observed_;
  const JointStep& joint_;
  const BlockLayout& layout_;
  GridLayers& layers_;
};

// What a step leaves of blocks that it need not work on.
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

// Those cells of a block of the step before of which something has been known.
CellBox seen_cells(const JointStep& joint, const CellBox& block) {
  const auto is_unseen = [&](int x, int y) { return joint.before.is_as_unseen(joint.step, x, y); };
  CellBox seen{block.x_last + 1, block.y_last + 1, -1, -1};
  for (int y{block.y_first}; y <= block.y_last; ++y) {
    int first{block.x_first};
    while (first <= block.x_last && is_unseen(first, y)) ++first;
    if (first > block.x_last) continue;
    int last{block.x_last};
    while (is_unseen(last, y)) --last;
    seen = {std::min(seen.x_first, first), std::min(seen.y_first, y), std::max(seen.x_last, last), y};
  }
  return seen;
}

// Which cells of a row of blocks of the step before move, and of which something has been known.
void find_cells(const JointStep& joint, int row) {
  const FilterState& before{joint.before};
  FilterSpace& space{joint.after.space};
  const BlockLayout& layout{before.blocks.layout()};
  for (int block{row * layout.across}; block < (row + 1) * layout.across; ++block) {
    CellBox& moving{space.moving[static_cast<std::size_t>(block)]};
    moving = {0, 0, -1, -1};
    space.active.set_seen(block, moving);
    if (before.is_unseen(block)) continue;
    moving = before.moving_cells(joint.step, joint.scroll, block);
    space.active.set_seen(block, seen_cells(joint, layout.cells_of(block)));
  }
}

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
      after.space.active.is_active(block) ? active.run(block) : unseen.write(block);
    }
  });
}

}  // namespace stereogrid
