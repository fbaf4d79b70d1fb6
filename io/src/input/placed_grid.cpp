// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {
namespace {

/// Index of the cell that holds a point; none: outside.
std::optional<std::size_t> cell_at(const GridGeometry& grid, Point2 at) {
  const double ix{std::floor((at.x - grid.x_min_m) / grid.cell_size_m)};
  const double iy{std::floor((at.y - grid.y_min_m) / grid.cell_size_m)};
  if (!(ix >= 0 && ix < grid.nx && iy >= 0 && iy < grid.ny)) return std::nullopt;
  return static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid.nx) + static_cast<std::size_t>(ix);
}

Point2 centre_of(const GridGeometry& grid, int ix, int iy) {
  return {grid.x_min_m + (ix + 0.5) * grid.cell_size_m, grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
}

}  // namespace

ObservedGrid resampled(const PlacedGrid& grid, const GridGeometry& geometry) {
  const ObservedGrid& source{grid.cells};
  ObservedGrid made{geometry, Image<float>{geometry.nx, geometry.ny}, Image<float>{geometry.nx, geometry.ny}};
  made.occupancy.fill(0.5F);
  const auto claim = [&](std::size_t cell) {
    return source.confidence.empty() ? 1.0F : source.confidence.data()[cell];
  };
  const auto put = [&](std::size_t to, std::size_t from) {
    made.occupancy.data()[to] = source.occupancy.data()[from];
    made.confidence.data()[to] = claim(from);
  };
  const Pose2 grid_from_vehicle{inverse(grid.vehicle_from_grid)};
  for (int iy{0}; iy < geometry.ny; ++iy) {
    for (int ix{0}; ix < geometry.nx; ++ix) {
      const auto from{cell_at(source.geometry, grid_from_vehicle * centre_of(geometry, ix, iy))};
      if (from) put(*cell_at(geometry, centre_of(geometry, ix, iy)), *from);
    }
  }
  for (int iy{0}; iy < source.geometry.ny; ++iy) {  // smaller cells: the most occupied one counts
    for (int ix{0}; ix < source.geometry.nx; ++ix) {
      const std::size_t from{static_cast<std::size_t>(iy) * static_cast<std::size_t>(source.geometry.nx) +
                             static_cast<std::size_t>(ix)};
      const float evidence{claim(from) * (source.occupancy.data()[from] - 0.5F)};
      if (!(evidence > 0)) continue;
      const auto to{cell_at(geometry, grid.vehicle_from_grid * centre_of(source.geometry, ix, iy))};
      if (to && evidence > made.confidence.data()[*to] * (made.occupancy.data()[*to] - 0.5F)) put(*to, from);
    }
  }
  return made;
}

}  // namespace stereogrid::io
