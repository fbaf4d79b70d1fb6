// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>

#include "observation/projection/projection.hpp"
#include "observation/projection/spans.hpp"

namespace stereogrid {

ProjectionWorkspace::ProjectionWorkspace(int width, int disparities)
    : largest(static_cast<std::size_t>(levels), Image<float>{width, disparities}) {}

void ProjectionWorkspace::plan(const BinGeometry& bins, const GridInVehicle& grid) {
  planned = grid;
  first_span.clear();
  spans.clear();
  const Spans found{largest[0].width(), largest[0].height(), bins, planned};
  const auto begin_cell = [&](int) { first_span.push_back(spans.size()); };
  const auto keep = [&](const BinSpan& span) { spans.push_back(span); };
  for (int iy{0}; iy < grid.grid.ny; ++iy) found.row_by_overlap(iy, begin_cell, keep);
  first_span.push_back(spans.size());
}

namespace {

// The largest occupancy among the bins of one disparity that satisfy `speaks`.
template <class Speaks>
float largest(View<const float> occupancy, int d, float so_far, const Speaks& speaks) {
  for (int u{0}; u < occupancy.width; ++u) {
    if (speaks(u)) so_far = std::max(so_far, occupancy(u, d));
  }
  return so_far;
}

float cell_by_overlap(View<const float> occupancy, const BinGeometry& bins, const CellCorners& cell) {
  float highest{-1};
  for (int d{0}; d < occupancy.height; ++d) {
    if (bins.nearest_x(d) >= cell.farthest_x() || bins.farthest_x(d) <= cell.nearest_x()) continue;
    const ColumnSpan span{columns_of(bins, cell, bins.nearest_x(d), bins.farthest_x(d))};
    highest = largest(occupancy, d, highest, [&](int u) { return span.touches(u); });
  }
  return highest;
}

}  // namespace

void project(Reference&, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             ProjectionWorkspace&, View<float> cells) {
  for (int iy{0}; iy < cells.height; ++iy) {
    for (int ix{0}; ix < cells.width; ++ix) {
      const CellCorners cell{grid.corners(ix, iy)};
      const float highest{cell.nearest_x() > 0 ? cell_by_overlap(occupancy, bins, cell) : -1};
      cells(ix, iy) = highest < 0 ? 0.5f : highest;
    }
  }
}

}  // namespace stereogrid
