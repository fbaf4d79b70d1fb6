// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "filter/joint/moving_blocks.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// Columns begin … end − 1.
struct CellColumns {
  int begin;
  int end;

  [[nodiscard]] bool is_empty() const { return end <= begin; }
};

/// Which blocks of the window a step has to work on: those with masses, and those with a cell of which something is, or
/// has been known. All other cells are as `unseen_cell` says. docs/method.md §8.7.
class ActiveBlocks {
 public:
  explicit ActiveBlocks(int window_cells);

  [[nodiscard]] bool is_active(int block) const { return active_[static_cast<std::size_t>(block)] != 0; }

  /// Observed cells of a block of the last state. Set for all blocks before `decide`.
  [[nodiscard]] CellBox& seen(int block) { return seen_[static_cast<std::size_t>(block)]; }
  /// Decides row `row` of the present blocks. `has_some(block)`: it has masses or observations; called only if needed.
  template <class HasSome>
  void decide(int row, Scroll scroll, const HasSome& has_some) {
    columns_[static_cast<std::size_t>(row)] = {layout_.cells, 0};
    for (int i{0}; i < layout_.across; ++i) {
      const int block{row * layout_.across + i};
      set_active(row, block, was_seen(layout_.cells_of(block), scroll) || has_some(block));
    }
  }

  /// The columns of the window now into which mass can come from row `row` of the blocks of the step before. After
  /// `decide` for all rows.
  [[nodiscard]] CellColumns reached_columns(int row, const FilterStep& step, Scroll scroll) const;

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(seen_, active_, columns_); }

 private:
  // Some of the cells that have since moved to `cells` have been known.
  [[nodiscard]] bool was_seen(const CellBox& cells, Scroll scroll) const;
  void set_active(int row, int block, bool is_active);

  BlockLayout layout_;
  std::vector<CellBox> seen_;
  std::vector<std::uint8_t> active_;
  std::vector<CellColumns> columns_;  // by row of blocks: columns around the active ones
};

}  // namespace stereogrid
