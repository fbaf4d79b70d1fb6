// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// Of the cells of a row of a block.
struct BlockRowSums {
  float mass[block_columns];
  float x[block_columns];
  float y[block_columns];
  float xx[block_columns];
  float xy[block_columns];
  float yy[block_columns];

  [[nodiscard]] VelocitySums at(int column) const {
    return {mass[column], x[column], y[column], xx[column], xy[column], yy[column]};
  }
};

/// What prediction reads of row y of the step before.
void prepare_row(const JointStep& joint, int y);

/// Row y of the step before, after prepare_row, moved on along x by each of the lattice's velocities: the sum, at the
/// columns of the window now.
void spread_along_x(const JointStep& joint, int y);

/// Cells of a row of a block of the window now.
struct BlockRow {
  int x;
  int y;
  int columns;
  float age_s[block_columns];     ///< before the step
  float standing[block_columns];  ///< what has arrived at standstill
  float each[block_columns];      ///< without masses: what has arrived of each moving velocity
  // the update of the masses
  float scale[block_columns];
  float born_moving[block_columns];
  float born_standing[block_columns];
};

/// What arrives of each moving velocity in columns `begin` … `end` − 1 of the row, which have no masses and have been
/// in the window before.
void arrive_evenly(const JointStep& joint, int begin, int end, BlockRow& row);

/// The masses that arrive in a block's cells.
void predict_block(const JointStep& joint, int block);

/// Sums over the masses of a row of a block; `masses`: of its first velocity.
void sum_row(const FilterTables& tables, const float* masses, BlockRowSums& sums);

/// Updates the row with what is observed: state and layers. `sums`: over the masses; null: it has none.
void update_row(const JointStep& joint, View<const float> observed, const BlockRowSums* sums, BlockRow& row,
                GridLayers& layers);

/// m(k) ← scale·m(k) + born(k) in a row of a block.
void rescale_row(const FilterStep& step, const BlockRow& row, float* masses);

}  // namespace stereogrid
