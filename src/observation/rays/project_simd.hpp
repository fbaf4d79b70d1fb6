// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "observation/rays/rays.hpp"

namespace stereogrid {

/// Cells of a grid: columns x_begin … x_end − 1 in rows y_begin … y_end − 1.
struct CellRange {
  int x_begin;
  int y_begin;
  int x_end;
  int y_end;
};

/// project_rays for some cells of a grid.
void project_ray_cells(const RaySums<Host>& sums, int most_columns, const CellsInView& in_view, const CellRange& range,
                       View<float> cells);

}  // namespace stereogrid
