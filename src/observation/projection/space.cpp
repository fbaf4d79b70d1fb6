// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
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

}  // namespace stereogrid
