// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "stereogrid/evaluation/scores.hpp"

namespace stereogrid::evaluation {
namespace {

/// Near edge (m ahead) of the first cell for which `test(ix, iy)`, on the ray y = slope · x.
template <class Test>
std::optional<double> first_along(const GridGeometry& grid, double slope, double from_m, Test test) {
  const int first{static_cast<int>(std::max(std::ceil((from_m - grid.x_min_m) / grid.cell_size_m - 1e-9), 0.0))};
  const auto row_at = [&](double x) {
    return static_cast<int>(std::floor((slope * x - grid.y_min_m) / grid.cell_size_m));
  };
  for (int ix{first}; ix < grid.nx; ++ix) {
    const double near_m{grid.x_min_m + ix * grid.cell_size_m};
    const int last_row{row_at(near_m + grid.cell_size_m)};
    for (int iy{row_at(near_m)};; iy += slope > 0 ? 1 : -1) {
      if (iy >= 0 && iy < grid.ny && test(ix, iy)) return near_m;
      if (iy == last_row) break;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<ColumnDepth> free_space(View<const float> probability, const Labels& labels, double from_m) {
  const GridGeometry& grid{labels.geometry};
  const double end_m{grid.x_min_m + grid.nx * grid.cell_size_m};
  std::vector<ColumnDepth> columns;
  for (int u{0}; u < labels.rig.width_px; ++u) {
    const double slope{-(u - labels.rig.cx_px) / labels.rig.focal_px};
    const auto truth{
        first_along(grid, slope, from_m, [&](int ix, int iy) { return labels.cells(ix, iy) == labelled_occupied; })};
    if (!truth) continue;
    const auto found{first_along(grid, slope, from_m, [&](int ix, int iy) { return probability(ix, iy) >= 0.5F; })};
    columns.push_back({static_cast<float>(*truth), static_cast<float>(found.value_or(end_m))});
  }
  return columns;
}

}  // namespace stereogrid::evaluation
