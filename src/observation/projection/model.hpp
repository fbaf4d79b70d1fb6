// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/grid_in_vehicle.hpp"
#include "host_device.hpp"
#include "stereogrid/camera.hpp"
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
