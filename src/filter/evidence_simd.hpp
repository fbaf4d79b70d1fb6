// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "filter/filter.hpp"

namespace stereogrid {

/// So many neighbouring cells are weighed together.
constexpr int evidence_cells{16};

/// Cells first_cell … first_cell + evidence_cells − 1 of the window.
struct WeighedCells {
  int first_cell;
  bool is_weighed[evidence_cells];  ///< the others have no evidence and stay as they are
  /// VelocityEvidence of each
  float x[evidence_cells];
  float y[evidence_cells];
  float xx[evidence_cells];
  float xy[evidence_cells];
  float yy[evidence_cells];
  /// VelocitySums of each afterwards
  float sum_mass[evidence_cells];
  float sum_x[evidence_cells];
  float sum_y[evidence_cells];
  float sum_xx[evidence_cells];
  float sum_xy[evidence_cells];
  float sum_yy[evidence_cells];
  float standing[evidence_cells];
};

/// `weigh` for cells side by side, equal to it on every instruction set. Works in `masses`: evidence_cells for each
/// velocity.
void weigh_cells(const std::vector<float>& axis_mps, FilterState& state, float* masses, WeighedCells& cells);

}  // namespace stereogrid
