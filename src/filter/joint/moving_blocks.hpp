// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "filter/joint/even_model.hpp"
#include "geometry/window.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// Leaves numbers without a given value unset, so that memory that is never written takes no time and no pages.
template <class Number>
struct UnsetAllocator : std::allocator<Number> {
  template <class Other>
  struct rebind {
    using other = UnsetAllocator<Other>;
  };

  template <class Other, class... Values>
  void construct(Other* place, Values&&... values) {
    if constexpr (sizeof...(values) == 0) {
      ::new (static_cast<void*>(place)) Other;
    } else {
      ::new (static_cast<void*>(place)) Other(std::forward<Values>(values)...);
    }
  }
};

/// Maximum number of blocks with masses.
constexpr int moving_blocks_max{512};

/// Masses over the velocity lattice of those blocks of a window that have some.
class MovingBlocks {
 public:
  /// With room for `capacity` blocks.
  MovingBlocks(int window_cells, std::size_t velocities, int capacity);

  [[nodiscard]] const BlockLayout& layout() const { return layout_; }
  /// Slot of a block's masses; −1: none.
  [[nodiscard]] int slot(int block) const { return slots_[static_cast<std::size_t>(block)]; }
  /// (velocities, block_rows, block_columns)
  [[nodiscard]] float* masses(int slot) { return masses_.data() + static_cast<std::size_t>(slot) * slot_size(); }
  [[nodiscard]] const float* masses(int slot) const {
    return masses_.data() + static_cast<std::size_t>(slot) * slot_size();
  }
  /// Masses of a cell, with stride block_cells between velocities; null: its block has none.
  [[nodiscard]] float* masses_at(int x, int y);
  [[nodiscard]] const float* masses_at(int x, int y) const { return const_cast<MovingBlocks*>(this)->masses_at(x, y); }

  void clear();
  /// Assigns uninitialised masses to blocks that moving cells can reach within a step, in the order of the blocks,
  /// while there is room. `moving`: by block of the last state.
  void begin(const FilterStep& step, Scroll scroll, std::span<const CellBox> moving);
  /// To be given masses, if the block has none.
  void want(int block);
  /// Assigns uninitialised masses to marked blocks, in their order, while there is room. Returns the new ones; valid
  /// until the next call.
  std::span<const int> allocate_marked();

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(slots_, masses_, begun_); }

  template <class State>
  void exchange(State& state) {
    std::vector<int> slots{slots_};
    std::vector<float> masses(masses_.begin(), masses_.begin() + static_cast<std::ptrdiff_t>(used_ * slot_size()));
    state(slots, masses);
    if constexpr (requires { state.require(true); }) state.require(take(slots, masses));
  }

 private:
  [[nodiscard]] std::size_t slot_size() const { return velocities_ * block_cells; }
  // False: they do not fit the layout.
  bool take(const std::vector<int>& slots, const std::vector<float>& masses);

  BlockLayout layout_;
  std::size_t velocities_;
  int capacity_;
  std::vector<int> slots_;
  std::vector<float, UnsetAllocator<float>> masses_;
  std::vector<int> begun_;
  int used_{0};
};

}  // namespace stereogrid
