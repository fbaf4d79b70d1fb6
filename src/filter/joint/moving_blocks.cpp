// SPDX-License-Identifier: Apache-2.0
#include "filter/joint/moving_blocks.hpp"

#include <algorithm>

namespace stereogrid {

MovingBlocks::MovingBlocks(int window_cells, std::size_t velocities, int capacity)
    : layout_{window_cells},
      velocities_{velocities},
      capacity_{capacity},
      slots_(static_cast<std::size_t>(layout_.count()), -1),
      masses_(static_cast<std::size_t>(capacity_) * slot_size()),
      begun_(static_cast<std::size_t>(capacity_)) {}

float* MovingBlocks::masses_at(int x, int y) {
  const int of_block{slot(layout_.block_of(x, y))};
  return of_block < 0 ? nullptr : masses(of_block) + y % block_rows * block_columns + x % block_columns;
}

void MovingBlocks::clear() {
  std::fill(slots_.begin(), slots_.end(), -1);
  used_ = 0;
}

void MovingBlocks::begin(const FilterStep& step, Scroll scroll, std::span<const CellBox> moving) {
  clear();
  for (const CellBox& cells : moving) {
    if (cells.is_empty()) continue;
    const CellBox reached{reached_blocks(step, cells, scroll.x, scroll.y, layout_.cells)};
    for (int y{reached.y_first}; y <= reached.y_last; ++y) {
      for (int x{reached.x_first}; x <= reached.x_last; ++x) want(y * layout_.across + x);
    }
  }
  allocate_marked();
}

void MovingBlocks::want(int block) {
  int& slot{slots_[static_cast<std::size_t>(block)]};
  if (slot < 0) slot = slot_wanted;
}

std::span<const int> MovingBlocks::allocate_marked() {
  std::size_t begun{0};
  for (int& slot : slots_) {
    if (slot != slot_wanted) continue;
    slot = used_ < capacity_ ? used_++ : -1;
    if (slot >= 0) begun_[begun++] = static_cast<int>(&slot - slots_.data());
  }
  return {begun_.data(), begun};
}

bool MovingBlocks::take(const std::vector<int>& slots, const std::vector<float>& masses) {
  if (slots.size() != slots_.size()) return false;
  std::vector<bool> is_taken(static_cast<std::size_t>(capacity_));
  int used{0};
  for (const int slot : slots) {
    if (slot == -1) continue;
    if (slot < 0 || slot >= capacity_ || is_taken[static_cast<std::size_t>(slot)]) return false;
    is_taken[static_cast<std::size_t>(slot)] = true;
    used = std::max(used, slot + 1);
  }
  if (masses.size() != static_cast<std::size_t>(used) * slot_size()) return false;
  slots_ = slots;
  used_ = used;
  std::copy(masses.begin(), masses.end(), masses_.begin());
  return true;
}

}  // namespace stereogrid
