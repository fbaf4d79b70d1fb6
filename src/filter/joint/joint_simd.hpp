// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "filter/filter.hpp"

namespace stereogrid {

/// A step of FilterModel::joint. The working memory of `after` describes `before`.
struct JointStep {
  const FilterStep& step;
  const FilterTables& tables;
  const FilterState& before;
  FilterState& after;
  Scroll scroll;
  float dt_s;
};

/// Sums of the cells of a row of a block.
struct BlockRowSums {
  float mass[block_columns];
  float x[block_columns];
  float y[block_columns];
  float xx[block_columns];
  float xy[block_columns];
  float yy[block_columns];
};

/// Which of `columns` cells from (x, y) on have been in the window before, counted from the first.
inline CellColumns known_columns(const JointStep& joint, int x, int y, int columns) {
  const int size{joint.before.occupancy.width()};
  const bool row_known{y + joint.scroll.y >= 0 && y + joint.scroll.y < size};
  const int first{x + joint.scroll.x};
  const int begin{row_known ? std::clamp(-first, 0, columns) : columns};
  return {begin, row_known ? std::clamp(size - first, begin, columns) : columns};
}

/// True if some cell of a block is observed: not exactly ½.
bool is_any_observed(View<const float> observed, const CellBox& cells);

/// Which cells of a row of blocks of the step before move, and of which something has been known.
void find_cells(const JointStep& joint, int block_row);

/// Prepares the prediction from row y of the last state.
void prepare_row(const JointStep& joint, int y, CellColumns columns);

/// Row y of the step before, after prepare_row, moved on along x by each of the lattice's velocities: the sum, at
/// columns of the window now.
void spread_along_x(const JointStep& joint, int y, CellColumns columns);

/// Cells of a row of a block of the window now.
struct BlockRow {
  int x;
  int y;
  int columns;
  bool was_even;                  ///< the layers say so of it before the step: BlockKind
  float age_s[block_columns];     ///< before the step
  float standing[block_columns];  ///< arriving mass of standstill
  float each[block_columns];      ///< without masses: arriving mass of each moving velocity
  float unseen[block_columns];    ///< 1: was as unseen_cell
  // the update of the masses
  float scale[block_columns];
  float birth_moving[block_columns];
  float birth_static[block_columns];
};

/// Reads the last state of a row that was completely in the window: age, standstill, unseen.
void take_before(const JointStep& joint, BlockRow& row);

/// Arriving mass of each moving velocity in some columns of the row that were in the window, as BlockRow::each.
void arrive_evenly(const JointStep& joint, CellColumns columns, BlockRow& row);

/// The masses that arrive in a block's cells.
void predict_block(const JointStep& joint, int block);

/// Sums over the masses of a row of a block; `masses`: of its first velocity.
void sum_row(const FilterTables& tables, const float* masses, BlockRowSums& sums);

/// Updates the row with the observation: state and layers. `sums`: over the masses; null: it has none.
void update_row(const JointStep& joint, View<const float> observed, const BlockRowSums* sums, BlockRow& row,
                GridLayers& layers);

/// m(k) ← scale·m(k) + birth(k) in a row of a block; 0 in columns beyond the window.
void rescale_row(const FilterStep& step, const BlockRow& row, float* masses);

}  // namespace stereogrid
