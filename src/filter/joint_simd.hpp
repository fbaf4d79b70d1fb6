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

/// What arrives in those cells of a row that have no masses of their own, and have been in the window before.
/// `x_begin` … `x_end` − 1: at most a block's.
void arrive_evenly(const JointStep& joint, int y, int x_begin, int x_end, float* each);

/// The masses that arrive in a block's cells.
void predict_block(const JointStep& joint, int block);

/// Sums over the masses of a row of a block; `masses`: of its first velocity.
void sum_row(const FilterTables& tables, const float* masses, BlockRowSums& sums);

/// m(k) ← scale·m(k) + born(k) in a row of a block.
void rescale_row(const FilterStep& step, const float* scale, const float* born_moving, const float* born_standing,
                 float* masses);

}  // namespace stereogrid
