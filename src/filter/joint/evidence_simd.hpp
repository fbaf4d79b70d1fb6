// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "filter/filter.hpp"

namespace stereogrid {

/// Cells that are weighed together: those of a row of a block, or any without masses.
struct WeighedCells {
  bool is_weighed[block_columns];  ///< the others have no evidence and stay as they are
  /// VelocityEvidence of each
  float x[block_columns];
  float y_mps[block_columns];
  float xx[block_columns];
  float xy[block_columns];
  float yy[block_columns];
  /// masses of the first velocity; null: `standing`, and `each` for each moving velocity
  float* masses;
  float each[block_columns];
  /// P(occupied, standstill), before and afterwards
  float standing[block_columns];
  /// VelocitySums of each afterwards
  float sum_mass[block_columns];
  float sum_x[block_columns];
  float sum_y[block_columns];
  float sum_xx[block_columns];
  float sum_xy[block_columns];
  float sum_yy[block_columns];
};

/// `weigh` for many cells, equal to it on every instruction set. Works in `space`, see
/// WeighingWorkspace::masses.
void weigh_cells(const std::vector<float>& axis_mps, float* space, WeighedCells& cells);

}  // namespace stereogrid
