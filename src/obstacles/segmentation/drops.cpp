// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "obstacles/segmentation/clusters.hpp"

namespace stereogrid {
namespace {

constexpr int sectors_apart_max{3};
constexpr double cells_apart_max{4};  ///< distance of neighbouring points, in cells
constexpr std::size_t edge_points_min{3};
constexpr std::size_t outline_points_max{24};
/// Least number of points, one a sector, of a sure edge. Errors of 33 px are correlated: a landing is fitted to three
/// sectors of 8 px, and the matcher's window adds 9. Three such parts agree. Checked on degraded drives
/// (docs/terrain.md).
constexpr std::size_t sure_points{12};

bool are_neighbours(const EdgePoint& a, const EdgePoint& b, double cell_m) {
  const double apart_m{std::hypot(a.place.x - b.place.x, a.place.y - b.place.y)};
  return b.sector - a.sector <= sectors_apart_max && apart_m <= cells_apart_max * cell_m;
}

double length_of(std::span<const EdgePoint> points) {
  const Point2 first{points.front().place};
  const Point2 last{points.back().place};
  return std::hypot(last.x - first.x, last.y - first.y);
}

Cluster drop_of(std::span<const EdgePoint> points, const GridLayers& world, const Pose2& world_from_vehicle) {
  Cluster cluster;
  cluster.kind = ObstacleKind::drop;
  cluster.is_cut_left = cluster.is_cut_right = true;  // the edge may continue where it is hidden
  const std::size_t outline_points{std::min(points.size(), outline_points_max)};
  for (std::size_t i{0}; i < outline_points; ++i) {
    cluster.outline.push_back(world_from_vehicle * points[i * (points.size() - 1) / (outline_points - 1)].place);
  }
  for (const EdgePoint& point : points) {
    cluster.height_m -= static_cast<double>(point.fall_m) / static_cast<double>(points.size());
    const auto cell = world.geometry.cell_at(world_from_vehicle * point.place);
    cluster.occupancy +=
        (cell ? static_cast<double>(world.occupancy(cell->ix, cell->iy)) : 0.5) / static_cast<double>(points.size());
  }
  cluster.bounds = bounds_of(cluster.outline);
  return cluster;
}

}  // namespace

void add_drops(const FrameEdges& edges, const GridLayers& world, const Pose2& world_from_vehicle,
               std::vector<Cluster>& clusters) {
  const std::span<const EdgePoint> points{edges.points};
  std::size_t first{0};
  for (std::size_t i{1}; i <= points.size(); ++i) {
    if (i < points.size() && are_neighbours(points[i - 1], points[i], world.geometry.cell_size_m)) continue;
    if (i - first >= edge_points_min) {
      const std::span<const EdgePoint> edge{points.subspan(first, i - first)};
      clusters.push_back(drop_of(edge, world, world_from_vehicle));
      clusters.back().is_sure = edge.size() >= sure_points && length_of(edge) >= edges.sure_m;
    }
    first = i;
  }
}

}  // namespace stereogrid
