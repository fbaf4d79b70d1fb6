// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/model.hpp"
#include "host_device.hpp"
#include "numbers.hpp"

namespace stereogrid {

// Blocks with little motion have no masses per velocity: their dynamic mass is spread evenly over the moving
// velocities. docs/method.md §8.7.

/// Cells that have masses for each velocity together.
constexpr int block_columns{16};
constexpr int block_rows{8};
constexpr int block_cells{block_columns * block_rows};

/// Thresholds with scene flow: more than the dynamic mass of an unknown cell, and more than the share of mass not seen
/// to move.
constexpr MovingFrom moving_from_flow{0.15f, 0.2f};
/// Thresholds otherwise: the smallest mass that the filter distinguishes from noise.
constexpr MovingFrom moving_found{0.05f, 0};

/// Cells of the window from the first to the last, both included.
struct CellBox {
  int x_first;
  int y_first;
  int x_last;
  int y_last;

  STEREOGRID_HD bool is_empty() const { return x_last < x_first; }
};

/// The window in blocks of cells; those at its right and lower border may reach beyond it.
struct BlockLayout {
  STEREOGRID_HD explicit BlockLayout(int window_cells)
      : cells{window_cells},
        across{(window_cells + block_columns - 1) / block_columns},
        along{(window_cells + block_rows - 1) / block_rows} {}

  [[nodiscard]] STEREOGRID_HD int count() const { return across * along; }
  [[nodiscard]] STEREOGRID_HD int block_of(int x, int y) const { return y / block_rows * across + x / block_columns; }
  /// Part of a block within the window.
  [[nodiscard]] STEREOGRID_HD CellBox cells_of(int block) const {
    const int x{block % across * block_columns};
    const int y{block / across * block_rows};
    return {x, y, Min(x + block_columns, cells) - 1, Min(y + block_rows, cells) - 1};
  }

  int cells;  ///< along a side of the window
  int across;
  int along;
};

/// Slot of a block without masses that is marked to get some.
constexpr int slot_wanted{-2};

/// Moving cells of a block. `moves(x, y)`.
template <class Moves>
STEREOGRID_HD inline CellBox moving_cells(const CellBox& block, const Moves& moves) {
  CellBox box{block.x_last + 1, block.y_last + 1, -1, -1};
  for (int y{block.y_first}; y <= block.y_last; ++y) {
    for (int x{block.x_first}; x <= block.x_last; ++x) {
      if (!moves(x, y)) continue;
      box = {Min(box.x_first, x), Min(box.y_first, y), Max(box.x_last, x), Max(box.y_last, y)};
    }
  }
  return box;
}

/// Blocks that the cells of a box can reach within a step, in a window of `cells` that has since moved on; in blocks,
/// from the first to the last. May be empty.
STEREOGRID_HD inline CellBox reached_blocks(const FilterStep& step, const CellBox& box, int moved_x, int moved_y,
                                            int cells) {
  const int x_first{Max(box.x_first - moved_x - step.reach, 0)};
  const int y_first{Max(box.y_first - moved_y - step.reach, 0)};
  const int x_last{Min(box.x_last - moved_x + step.reach, cells - 1)};
  const int y_last{Min(box.y_last - moved_y + step.reach, cells - 1)};
  if (x_last < x_first || y_last < y_first) return {0, 0, -1, -1};
  return {x_first / block_columns, y_first / block_rows, x_last / block_columns, y_last / block_rows};
}

/// A block of the step before can have masses, if some of its cells move: its middle is not too far from the camera.
STEREOGRID_HD inline bool is_followed(const FilterStep& step, const CellBox& block, int moved_x, int moved_y) {
  const float dx{0.5f * static_cast<float>(block.x_first + block.x_last) - static_cast<float>(moved_x) -
                 step.views[0].camera_x};
  const float dy{0.5f * static_cast<float>(block.y_first + block.y_last) - static_cast<float>(moved_y) -
                 step.views[0].camera_y};
  return dx * dx + dy * dy <= step.moving_squares;
}

/// Mass of each moving velocity outside the window.
STEREOGRID_HD inline float even_outside(const FilterStep& step) {
  return step.border_occupancy * step.prior_moving;
}

/// Arriving mass in a cell without masses of its own.
struct EvenArrived {
  float standing;
  float each;  ///< mass of each moving velocity
};

/// A cell that has just come into the window.
STEREOGRID_HD inline EvenArrived new_to_the_window(const FilterStep& step) {
  return {0.5f * step.prior_static, 0.5f * step.prior_moving};
}

}  // namespace stereogrid
