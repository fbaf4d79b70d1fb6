// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "nearest_obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stereogrid::evaluation {

NearestObstacle::NearestObstacle(const Rig& rig)
    : rig_{rig}, nearest_m_(static_cast<std::size_t>(rig.width_px), std::numeric_limits<double>::infinity()) {}

double NearestObstacle::column_of(double x_m, double y_m) const {
  return rig_.cx_px - rig_.focal_px * y_m / x_m;
}

void NearestObstacle::add(double x_m, double y_m, double columns) {
  const double u{column_of(x_m, y_m)};
  const double first{std::max(std::ceil(u - columns), 0.0)};
  const double last{std::min(std::floor(u + columns), rig_.width_px - 1.0)};
  for (double column{first}; column <= last; ++column) {
    double& nearest{nearest_m_[static_cast<std::size_t>(column)]};
    nearest = std::min(nearest, x_m);
  }
}

bool NearestObstacle::hides(const GridGeometry& grid, int ix, int iy) const {
  const double near_m{grid.x_min_m + ix * grid.cell_size_m};
  if (near_m <= hiding_margin_m) return false;
  const double far_m{near_m + grid.cell_size_m};
  const double right_m{grid.y_min_m + iy * grid.cell_size_m};
  const double left_m{right_m + grid.cell_size_m};
  const double from{std::min(column_of(near_m, left_m), column_of(far_m, left_m))};
  const double to{std::max(column_of(near_m, right_m), column_of(far_m, right_m))};
  const double first{std::max(std::floor(from + 0.5), 0.0)};
  const double last{std::min(std::floor(to + 0.5), rig_.width_px - 1.0)};
  if (first > last) return false;
  return std::all_of(nearest_m_.begin() + static_cast<std::ptrdiff_t>(first),
                     nearest_m_.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                     [&](double nearest) { return nearest < near_m - hiding_margin_m; });
}

void mark_partly_hidden(const NearestObstacle& nearest, Labels& labels) {
  for (int iy{0}; iy < labels.cells.height(); ++iy) {
    for (int ix{0}; ix < labels.cells.width(); ++ix) {
      if (labels.cells(ix, iy) == not_scored) continue;
      labels.partly_hidden(ix, iy) = nearest.hides(labels.geometry, ix, iy) ? 1 : 0;
    }
  }
}

}  // namespace stereogrid::evaluation
