// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <cmath>

#include "projection/projection.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{4};

int clamped(double value, int highest) {
  return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(highest)));
}

// Largest occupancy of row d for the columns that satisfy `speaks`; they are an interval around [smallest, largest].
template <class Speaks>
float largest(View<const float> occupancy, int d, float so_far, const ColumnSpan& span, const Speaks& speaks) {
  const int last{occupancy.width - 1};
  int begin{std::max(clamped(std::floor(span.smallest - 1), last), 0)};
  int end{clamped(std::ceil(span.largest + 1), last)};
  while (begin <= end && !speaks(begin)) ++begin;
  while (end >= begin && !speaks(end)) --end;
  const float* row{occupancy.row(d)};
  for (int u{begin}; u <= end; ++u) so_far = row[u] > so_far ? row[u] : so_far;
  return so_far;
}

float cell_by_overlap(View<const float> occupancy, const BinGeometry& bins, const CellCorners& cell) {
  const double near{cell.nearest_x()};
  const double far{cell.farthest_x()};
  float highest{-1};
  int d{std::max(clamped(std::floor(bins.disparity(far) - 1.5), occupancy.height - 1), 0)};
  for (; d < occupancy.height && bins.farthest_x(d) > near; ++d) {
    if (bins.nearest_x(d) >= far) continue;
    const ColumnSpan span{columns_of(bins, cell, bins.nearest_x(d), bins.farthest_x(d))};
    highest = largest(occupancy, d, highest, span, [&](int u) { return span.touches(u); });
  }
  return highest;
}

float cell_by_centre(View<const float> occupancy, const BinGeometry& bins, const CellCorners& cell, Point2 centre) {
  const double near{cell.nearest_x()};
  const double far{cell.farthest_x()};
  float highest{-1};
  int d{std::max(clamped(std::floor(bins.disparity(far) - 0.5), occupancy.height - 1), 1)};
  for (; d < occupancy.height; ++d) {
    const double x{bins.focal_baseline_pxm / d};
    if (x > far) continue;
    if (x < near) break;
    const ColumnSpan span{columns_of(bins, cell, x, x)};
    highest = largest(occupancy, d, highest, span, [&](int u) { return span.holds(u); });
  }
  const double at_d{std::floor(bins.disparity(centre.x) + 0.5)};
  const double at_u{std::floor(bins.column(centre.x, centre.y) + 0.5)};
  if (at_d >= 0 && at_d < occupancy.height && at_u >= 0 && at_u < occupancy.width) {
    highest = std::max(highest, occupancy(static_cast<int>(at_u), static_cast<int>(at_d)));
  }
  return highest;
}

}  // namespace

void project(Cpu& cpu, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             Footprint footprint, View<float> cells) {
  cpu.for_ranges(cells.height, rows_grain, [&](int begin, int end) {
    for (int iy{begin}; iy < end; ++iy) {
      for (int ix{0}; ix < cells.width; ++ix) {
        const CellCorners cell{grid.corners(ix, iy)};
        float highest{-1};
        if (cell.nearest_x() > 0) {
          highest = footprint == Footprint::overlap ? cell_by_overlap(occupancy, bins, cell)
                                                    : cell_by_centre(occupancy, bins, cell, grid.centre(ix, iy));
        }
        cells(ix, iy) = highest < 0 ? 0.5f : highest;
      }
    }
  });
}

}  // namespace stereogrid
