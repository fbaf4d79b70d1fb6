// SPDX-License-Identifier: Apache-2.0
//
// Clusters of the terrain: edges with lower ground behind them, and low obstacles in memory.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

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
/// Least number of cells of a low obstacle: errors in a lone cell last. And of frames in all of them.
constexpr std::ptrdiff_t low_cells_min{2};
constexpr float low_frames_min{1};
/// Low obstacles that are longer, or whose cells fill less of their box, are boundaries, as kerbs.
constexpr double low_object_m{8};
constexpr double low_object_fill{0.5};
constexpr int low_object_points{8};     ///< maximum of an outline
constexpr int low_boundary_points{12};  ///< likewise
/// Standard deviation of a low obstacle's velocity, which is 0.
constexpr double low_sigma_mps{0.1};

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

int first_of(std::span<LowObstacleCell> cells, int index) {
  const auto group_of = [&](int i) -> int& { return cells[static_cast<std::size_t>(i)].group; };
  while (group_of(index) != index) index = group_of(index) = group_of(group_of(index));
  return index;
}

// Sorts the cells by group, and by rows within it.
void group(std::span<LowObstacleCell> cells) {
  for (std::size_t i{0}; i < cells.size(); ++i) {
    cells[i].group = static_cast<int>(i);
    for (std::size_t k{i}; k-- > 0 && cells[k].iy >= cells[i].iy - 1;) {
      if (std::abs(cells[k].ix - cells[i].ix) > 1) continue;
      const auto [first, other] = std::minmax({first_of(cells, cells[i].group), first_of(cells, cells[k].group)});
      cells[static_cast<std::size_t>(other)].group = first;
    }
  }
  for (LowObstacleCell& cell : cells) cell.group = first_of(cells, cell.group);
  std::ranges::sort(cells, {}, [](const LowObstacleCell& cell) { return std::tuple{cell.group, cell.iy, cell.ix}; });
}

// The outermost corners of the cells in low_object_points directions: a convex polygon.
Outline around(std::span<const LowObstacleCell> cells, const GridGeometry& grid) {
  Outline outline;
  for (int i{0}; i < low_object_points; ++i) {
    const double direction_rad{(i + 0.5) * 2 * M_PI / low_object_points};
    const double c{std::cos(direction_rad)};
    const double s{std::sin(direction_rad)};
    const LowObstacleCell& cell{
        *std::ranges::max_element(cells, {}, [&](const LowObstacleCell& of) { return c * of.ix + s * of.iy; })};
    const Point2 centre{grid.centre(cell.ix, cell.iy)};
    const Point2 corner{centre.x + std::copysign(grid.cell_size_m / 2, c),
                        centre.y + std::copysign(grid.cell_size_m / 2, s)};
    const auto is_corner = [&](Point2 point) { return point.x == corner.x && point.y == corner.y; };
    if (std::ranges::none_of(outline, is_corner)) outline.push_back(corner);
  }
  return outline;
}

// The nearest cells of low_boundary_points parts of the view, from left to right.
Outline near_side(std::span<const LowObstacleCell> cells, const GridGeometry& grid, const Pose2& world_from_vehicle) {
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  const auto bearing = [&](const LowObstacleCell& cell) {
    const Point2 at{vehicle_from_world * grid.centre(cell.ix, cell.iy)};
    return std::atan2(at.y, at.x);
  };
  const auto [right, left] = std::ranges::minmax(cells, {}, bearing);
  const double right_rad{bearing(right)};
  const double part_rad{(bearing(left) - right_rad) / low_boundary_points};
  std::array<const LowObstacleCell*, low_boundary_points> nearest{};
  const auto range = [&](const LowObstacleCell& cell) {
    const Point2 at{grid.centre(cell.ix, cell.iy)};
    return std::hypot(at.x - world_from_vehicle.x_m, at.y - world_from_vehicle.y_m);
  };
  for (const LowObstacleCell& cell : cells) {
    const int part{static_cast<int>((bearing(cell) - right_rad) / std::max(part_rad, 1e-6))};
    const LowObstacleCell*& at{nearest[static_cast<std::size_t>(std::min(part, low_boundary_points - 1))]};
    if (at == nullptr || range(cell) < range(*at)) at = &cell;
  }
  Outline outline;
  for (std::size_t i{nearest.size()}; i-- > 0;) {
    if (nearest[i] != nullptr) outline.push_back(grid.centre(nearest[i]->ix, nearest[i]->iy));
  }
  return outline;
}

Cluster low_object_of(std::span<const LowObstacleCell> cells, const GridLayers& world,
                      const Pose2& world_from_vehicle) {
  Cluster cluster;
  cluster.is_low = true;
  cluster.is_seen = std::ranges::any_of(cells, &LowObstacleCell::is_seen);
  cluster.velocity_covariance = {low_sigma_mps * low_sigma_mps, 0, low_sigma_mps * low_sigma_mps};
  for (const LowObstacleCell& cell : cells) {
    cluster.height_m = std::max(cluster.height_m, static_cast<double>(cell.height_m));
    cluster.occupancy += static_cast<double>(world.occupancy(cell.ix, cell.iy)) / static_cast<double>(cells.size());
  }
  const GridGeometry& grid{world.geometry};
  cluster.outline = around(cells, grid);
  fit_boxes({&cluster, 1});
  const double filled_m2{static_cast<double>(cells.size()) * grid.cell_size_m * grid.cell_size_m};
  if (cluster.length_m > low_object_m || filled_m2 < low_object_fill * cluster.length_m * cluster.width_m) {
    cluster.kind = ObstacleKind::boundary;
    cluster.is_cut_left = cluster.is_cut_right = true;
    cluster.outline = near_side(cells, grid, world_from_vehicle);
  }
  cluster.bounds = bounds_of(cluster.outline);
  return cluster;
}

}  // namespace

void add_low_objects(std::span<LowObstacleCell> cells, const GridLayers& world, const Pose2& world_from_vehicle,
                     std::vector<Cluster>& clusters) {
  group(cells);
  for (auto first = cells.begin(); first != cells.end();) {
    const auto end =
        std::find_if(first, cells.end(), [&](const LowObstacleCell& cell) { return cell.group != first->group; });
    const auto add = [](float frames, const LowObstacleCell& cell) { return frames + cell.frames; };
    if (end - first >= low_cells_min && std::accumulate(first, end, 0.0f, add) >= low_frames_min)
      clusters.push_back(low_object_of({first, end}, world, world_from_vehicle));
    first = end;
  }
}

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
