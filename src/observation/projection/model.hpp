// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "host_device.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// The ground seen from the camera: a bin of the u-disparity plane lies at x = f·b/d, y = −(u − u0)·x/f in the vehicle
/// frame (eq. 3, origin at the left camera).
struct BinGeometry {
  double focal_px;
  double cx_px;
  double focal_baseline_pxm;

  STEREOGRID_HD explicit BinGeometry(const Rig& rig)
      : focal_px{rig.focal_px}, cx_px{rig.cx_px}, focal_baseline_pxm{rig.focal_px * rig.baseline_m} {}

  [[nodiscard]] STEREOGRID_HD double nearest_x(int d) const { return focal_baseline_pxm / (d + 0.5); }
  [[nodiscard]] STEREOGRID_HD double farthest_x(int d) const { return d > 0 ? focal_baseline_pxm / (d - 0.5) : 1e30; }
  [[nodiscard]] STEREOGRID_HD double column(double x, double y) const { return cx_px - focal_px * y / x; }
  [[nodiscard]] STEREOGRID_HD double disparity(double x) const { return focal_baseline_pxm / x; }
};

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

/// Columns between which the part of a cell within a bin's depth is seen; empty where smallest > largest.
struct ColumnSpan {
  double smallest{1e30};
  double largest{-1e30};

  STEREOGRID_HD void take(double u) {
    smallest = u < smallest ? u : smallest;
    largest = u > largest ? u : largest;
  }
  /// True if the bin's column [u − ½, u + ½] shares an area with it.
  [[nodiscard]] STEREOGRID_HD bool touches(int u) const { return u + 0.5 > smallest && u - 0.5 < largest; }
};

/// Clips the cell to the depths between `x_near` and `x_far` and projects it into the camera. Straight edges stay
/// straight in the image, so the corners of the clipped cell span all columns that see it.
STEREOGRID_HD inline ColumnSpan columns_of(const BinGeometry& bins, const CellCorners& cell, double x_near,
                                           double x_far) {
  ColumnSpan span;
  for (int i{0}; i < 4; ++i) {
    const Point2 a{cell.corner[i]};
    const Point2 b{cell.corner[(i + 1) % 4]};
    if (a.x >= x_near && a.x <= x_far) span.take(bins.column(a.x, a.y));
    for (int side{0}; side < 2; ++side) {
      const double x{side == 0 ? x_near : x_far};
      if ((a.x < x) == (b.x < x)) continue;
      const double part{(x - a.x) / (b.x - a.x)};
      span.take(bins.column(x, a.y + part * (b.y - a.y)));
    }
  }
  return span;
}

}  // namespace stereogrid
