// SPDX-License-Identifier: Apache-2.0
#include "filter/joint/active_blocks.hpp"

#include <algorithm>

namespace stereogrid {

ActiveBlocks::ActiveBlocks(int window_cells)
    : layout_{window_cells},
      seen_(static_cast<std::size_t>(layout_.count())),
      active_(static_cast<std::size_t>(layout_.count())),
      columns_(static_cast<std::size_t>(layout_.along)) {}

bool ActiveBlocks::was_seen(const CellBox& cells, Scroll scroll) const {
  const int last{layout_.cells - 1};
  const CellBox before{std::max(cells.x_first + scroll.x, 0), std::max(cells.y_first + scroll.y, 0),
                       std::min(cells.x_last + scroll.x, last), std::min(cells.y_last + scroll.y, last)};
  if (before.x_last < before.x_first || before.y_last < before.y_first) return false;
  for (int y{before.y_first / block_rows}; y <= before.y_last / block_rows; ++y) {
    for (int x{before.x_first / block_columns}; x <= before.x_last / block_columns; ++x) {
      const CellBox& seen{seen_[static_cast<std::size_t>(y * layout_.across + x)]};
      const bool is_apart{seen.is_empty() || seen.x_first > before.x_last || seen.x_last < before.x_first ||
                          seen.y_first > before.y_last || seen.y_last < before.y_first};
      if (!is_apart) return true;
    }
  }
  return false;
}

void ActiveBlocks::set_active(int row, int block, bool is_active) {
  active_[static_cast<std::size_t>(block)] = is_active ? 1 : 0;
  if (!is_active) return;
  const CellBox cells{layout_.cells_of(block)};
  CellColumns& columns{columns_[static_cast<std::size_t>(row)]};
  columns = {std::min(columns.begin, cells.x_first), std::max(columns.end, cells.x_last + 1)};
}

CellColumns ActiveBlocks::reached_columns(int row, const FilterStep& step, Scroll scroll) const {
  const int around{step.reach + 1};
  const int first{std::max(row * block_rows - scroll.y - around, 0)};
  const int last{std::min((row + 1) * block_rows - 1 - scroll.y + around, layout_.cells - 1)};
  CellColumns reached{layout_.cells, 0};
  for (int i{first / block_rows}; first <= last && i <= last / block_rows; ++i) {
    const CellColumns columns{columns_[static_cast<std::size_t>(i)]};
    reached = {std::min(reached.begin, columns.begin), std::max(reached.end, columns.end)};
  }
  return reached;
}

}  // namespace stereogrid
