// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "geometry/window.hpp"

#include <cmath>

#include "clamped_to_int.hpp"

namespace stereogrid {

Window::Window(const GridGeometry& grid)
    : cell_size_m_{grid.cell_size_m},
      ahead_m_{grid.x_min_m + grid.nx * grid.cell_size_m / 2},
      aside_m_{grid.y_min_m + grid.ny * grid.cell_size_m / 2},
      cells_{static_cast<int>(std::ceil(std::hypot(grid.nx, grid.ny))) + 4} {}

GridGeometry Window::at(const Pose2& world_from_vehicle) const {
  const Point2 centre{world_from_vehicle * Point2{ahead_m_, aside_m_}};
  const int half{cells_ / 2};
  const double first_x{std::floor(centre.x / cell_size_m_) - half};
  const double first_y{std::floor(centre.y / cell_size_m_) - half};
  return {first_x * cell_size_m_, first_y * cell_size_m_, cell_size_m_, cells_, cells_};
}

Scroll scroll_between(const GridGeometry& before, const GridGeometry& now) {
  return {clamped_to_int(std::round((now.x_min_m - before.x_min_m) / now.cell_size_m)),
          clamped_to_int(std::round((now.y_min_m - before.y_min_m) / now.cell_size_m))};
}

}  // namespace stereogrid
