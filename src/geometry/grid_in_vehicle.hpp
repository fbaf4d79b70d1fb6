// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "host_device.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// The corners of a cell in the vehicle frame, in order around it.
struct CellCorners {
  Point2 corner[4];

  [[nodiscard]] STEREOGRID_HD double nearest_x() const {
    double x{corner[0].x};
    for (int i{1}; i < 4; ++i) x = corner[i].x < x ? corner[i].x : x;
    return x;
  }
  [[nodiscard]] STEREOGRID_HD double farthest_x() const {
    double x{corner[0].x};
    for (int i{1}; i < 4; ++i) x = corner[i].x > x ? corner[i].x : x;
    return x;
  }
};

/// Corners of cell (ix, iy); the grid's own frame is placed in the vehicle frame by (x_m, y_m) and a rotation.
struct GridInVehicle {
  GridGeometry grid;
  double x_m{0};
  double y_m{0};
  double cos_yaw{1};
  double sin_yaw{0};

  [[nodiscard]] STEREOGRID_HD Point2 to_vehicle(double x, double y) const {
    return {x_m + cos_yaw * x - sin_yaw * y, y_m + sin_yaw * x + cos_yaw * y};
  }
  [[nodiscard]] STEREOGRID_HD CellCorners corners(int ix, int iy) const {
    const double x0{grid.x_min_m + ix * grid.cell_size_m};
    const double y0{grid.y_min_m + iy * grid.cell_size_m};
    const double x1{grid.x_min_m + (ix + 1) * grid.cell_size_m};
    const double y1{grid.y_min_m + (iy + 1) * grid.cell_size_m};
    return {{to_vehicle(x0, y0), to_vehicle(x1, y0), to_vehicle(x1, y1), to_vehicle(x0, y1)}};
  }
  [[nodiscard]] STEREOGRID_HD Point2 centre(int ix, int iy) const {
    return to_vehicle(grid.x_min_m + (ix + 0.5) * grid.cell_size_m, grid.y_min_m + (iy + 0.5) * grid.cell_size_m);
  }
};

/// Position of a grid, from its pose. Computed on the host, so that both back ends use the same sine and cosine.
[[nodiscard]] inline GridInVehicle grid_in_vehicle(const GridGeometry& grid, const Pose2& vehicle_from_grid) {
  return {grid, vehicle_from_grid.x_m, vehicle_from_grid.y_m, std::cos(vehicle_from_grid.yaw_rad),
          std::sin(vehicle_from_grid.yaw_rad)};
}

/// The centres of such a grid's cells in single precision: of whole steps exact, else to 1e-4 of a cell in grids of
/// 1000.
struct CellPlaces {
  float x;  ///< position of the cell (0, 0)
  float y;
  float along;  ///< a step by ix is (along, across), a step by iy (−across, along)
  float across;

  /// In units of `unit_m` from `origin` on.
  STEREOGRID_HD CellPlaces(const GridInVehicle& cells, Point2 origin, double unit_m)
      : x{static_cast<float>((cells.centre(0, 0).x - origin.x) / unit_m)},
        y{static_cast<float>((cells.centre(0, 0).y - origin.y) / unit_m)},
        along{static_cast<float>(cells.cos_yaw * (cells.grid.cell_size_m / unit_m))},
        across{static_cast<float>(cells.sin_yaw * (cells.grid.cell_size_m / unit_m))} {}

  [[nodiscard]] STEREOGRID_HD float x_of(int ix, int iy) const {
    return (x - across * static_cast<float>(iy)) + along * static_cast<float>(ix);
  }
  [[nodiscard]] STEREOGRID_HD float y_of(int ix, int iy) const {
    return (y + along * static_cast<float>(iy)) + across * static_cast<float>(ix);
  }
};

}  // namespace stereogrid
