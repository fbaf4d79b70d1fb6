// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "observation/rays/rays.hpp"

namespace stereogrid {

/// Columns that are counted together: their counts stay in the first cache.
constexpr int ray_block_columns{16};

using AmbiguousPixels = std::array<std::int32_t, ray_block_columns>;

/// Counts the rays of columns begin … end − 1, at most ray_block_columns, in each bin: count_ray of every pixel.
/// `space.sums` has the counts of column u and bin k at (k + 1, u + 1). Returns the number of ambiguous pixels of each.
AmbiguousPixels count_ray_block(const Matches& matches, int begin, int end, RayWorkspace& space);

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
