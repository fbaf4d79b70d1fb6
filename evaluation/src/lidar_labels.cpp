// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "nearest_obstacle.hpp"
#include "road_plane.hpp"
#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double obstacle_from_m{0.3};
constexpr double obstacle_to_m{1.8};
constexpr double road_within_m{0.12};
constexpr int obstacle_points_min{2};
constexpr double ahead_min_m{1};
constexpr double column_reach{1.5};  // returns are about 2 columns apart on KITTI: no gaps within a surface

bool in_view(const CameraPoint& p, const Rig& rig) {
  const double u{rig.centre_u_px + rig.focal_px * p.x_m / std::max(p.z_m, 0.1)};
  return p.z_m > ahead_min_m && u > 0 && u < rig.width_px;
}

struct Counts {
  Image<int> obstacle;
  Image<int> road;
};

void count(Image<int>& points, const CameraPoint& p, const GridGeometry& grid) {
  const double ix{std::floor((p.z_m - grid.x_min_m) / grid.cell_size_m)};
  const double iy{std::floor((-p.x_m - grid.y_min_m) / grid.cell_size_m)};
  if (ix < 0 || iy < 0 || ix >= grid.nx || iy >= grid.ny) return;
  ++points(static_cast<int>(ix), static_cast<int>(iy));
}

void label(const Counts& counts, Image<std::int8_t>& cells) {
  for (std::size_t i{0}; i < cells.size(); ++i) {
    const int obstacle{counts.obstacle.data()[i]};
    if (obstacle >= obstacle_points_min) {
      cells.data()[i] = labelled_occupied;
    } else if (obstacle == 0 && counts.road.data()[i] > 0) {
      cells.data()[i] = labelled_free;
    }
  }
}

}  // namespace

Labels lidar_labels(std::span<const CameraPoint> points, const Rig& rig, const GridGeometry& grid,
                    double camera_height_m) {
  Labels labels{grid, rig, {grid.nx, grid.ny, not_scored}, {grid.nx, grid.ny}};
  Counts counts{{grid.nx, grid.ny}, {grid.nx, grid.ny}};
  NearestObstacle nearest{rig};
  const RoadPlane road{fit_road(points, camera_height_m)};
  for (const CameraPoint& p : points) {
    if (!in_view(p, rig)) continue;
    const double height{road.height_of(p)};
    if (height > obstacle_from_m && height < obstacle_to_m) {
      count(counts.obstacle, p, grid);
      nearest.add(p.z_m, -p.x_m, column_reach);
    } else if (std::abs(height) < road_within_m) {
      count(counts.road, p, grid);
    }
  }
  label(counts, labels.cells);
  mark_partly_hidden(nearest, labels);
  return labels;
}

}  // namespace stereogrid::evaluation
