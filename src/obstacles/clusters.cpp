// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "obstacles/tracking.hpp"

namespace stereogrid {
namespace {

constexpr double velocity_gap_mps{4.0};
constexpr double moving_mps{0.7};

using Cell = ClusterSpace::Cell;

Point2 centre_of(const GridGeometry& grid, Cell cell) {
  return grid.centre(cell.x, cell.y);
}

bool is_active(const GridLayers& world, const TrackingConfig& config, int x, int y) {
  return world.occupancy(x, y) >= config.occupancy_min && std::isfinite(world.age_s(x, y));
}

// What stands and what moves are two things, and so are two that move differently. A cell's velocity is compared with
// the mean of the cells taken so far and not with its neighbour's: from one thing to another that passes close by,
// velocities change in small steps.
class MeanVelocity {
 public:
  void take(const GridLayers& world, Cell cell) {
    if (count_ == 0) moves_ = moves(world, cell.x, cell.y);
    ++count_;
    mean_.x += (world.velocity_x(cell.x, cell.y) - mean_.x) / count_;
    mean_.y += (world.velocity_y(cell.x, cell.y) - mean_.y) / count_;
  }
  [[nodiscard]] bool is_like(const GridLayers& world, int x, int y) const {
    return moves(world, x, y) == moves_ &&
           std::hypot(world.velocity_x(x, y) - mean_.x, world.velocity_y(x, y) - mean_.y) < velocity_gap_mps;
  }

 private:
  static bool moves(const GridLayers& world, int x, int y) { return world.moving(x, y) > 0.5f * world.occupancy(x, y); }

  int count_{0};
  bool moves_{false};
  Point2 mean_;
};

void grow(const GridLayers& world, const TrackingConfig& config, int label, Image<int>& labels,
          std::vector<Cell>& cells) {
  MeanVelocity mean;
  mean.take(world, cells.front());
  for (std::size_t next{0}; next < cells.size(); ++next) {
    const Cell cell{cells[next]};
    for (int y{std::max(cell.y - 1, 0)}; y <= std::min(cell.y + 1, labels.height() - 1); ++y) {
      for (int x{std::max(cell.x - 1, 0)}; x <= std::min(cell.x + 1, labels.width() - 1); ++x) {
        if (labels(x, y) != 0 || !is_active(world, config, x, y) || !mean.is_like(world, x, y)) continue;
        labels(x, y) = label;
        cells.push_back({x, y});
        mean.take(world, {x, y});
      }
    }
  }
}

// Direction of the longer side, from the second moments of the cells.
double principal_axis(const GridLayers& world, const std::vector<Cell>& cells, Point2 mean) {
  double xx{0};
  double xy{0};
  double yy{0};
  for (const Cell cell : cells) {
    const Point2 at{centre_of(world.geometry, cell)};
    xx += (at.x - mean.x) * (at.x - mean.x);
    xy += (at.x - mean.x) * (at.y - mean.y);
    yy += (at.y - mean.y) * (at.y - mean.y);
  }
  return 0.5 * std::atan2(2 * xy, xx - yy);
}

// Bounding box along `yaw`; its middle is the cluster's centre.
void fit_box(const GridLayers& world, const std::vector<Cell>& cells, Cluster& cluster) {
  const double c{std::cos(cluster.yaw_rad)};
  const double s{std::sin(cluster.yaw_rad)};
  double along_min{std::numeric_limits<double>::max()};
  double along_max{std::numeric_limits<double>::lowest()};
  double across_min{along_min};
  double across_max{along_max};
  for (const Cell cell : cells) {
    const Point2 at{centre_of(world.geometry, cell)};
    const double along{c * at.x + s * at.y};
    const double across{-s * at.x + c * at.y};
    along_min = std::min(along_min, along);
    along_max = std::max(along_max, along);
    across_min = std::min(across_min, across);
    across_max = std::max(across_max, across);
  }
  const double along{(along_min + along_max) / 2};
  const double across{(across_min + across_max) / 2};
  cluster.centre = {c * along - s * across, s * along + c * across};
  cluster.length_m = along_max - along_min + world.geometry.cell_size_m;
  cluster.width_m = across_max - across_min + world.geometry.cell_size_m;
}

Cluster describe(const GridLayers& world, const std::vector<Cell>& cells) {
  Cluster cluster;
  cluster.cells = static_cast<int>(cells.size());
  const double weight{1.0 / cluster.cells};
  Point2 mean;
  for (const Cell cell : cells) {
    const Point2 at{centre_of(world.geometry, cell)};
    mean.x += weight * at.x;
    mean.y += weight * at.y;
    cluster.velocity.x += weight * world.velocity_x(cell.x, cell.y);
    cluster.velocity.y += weight * world.velocity_y(cell.x, cell.y);
    cluster.occupancy += weight * world.occupancy(cell.x, cell.y);
  }
  const bool moving{std::hypot(cluster.velocity.x, cluster.velocity.y) > moving_mps};
  cluster.yaw_rad = moving ? std::atan2(cluster.velocity.y, cluster.velocity.x) : principal_axis(world, cells, mean);
  fit_box(world, cells, cluster);
  return cluster;
}

}  // namespace

ClusterSpace::ClusterSpace(int nx, int ny, std::size_t points) : labels{nx, ny} {
  clusters.reserve(things_reserved);
  cells.reserve(labels.size());
  followed.reserve(points);
  values.reserve(points);
}

void find_clusters(const GridLayers& world, const TrackingConfig& config, ClusterSpace& space) {
  std::vector<Cluster>& clusters{space.clusters};
  Image<int>& labels{space.labels};
  std::vector<Cell>& cells{space.cells};
  clusters.clear();
  labels.fill(0);
  for (int y{0}; y < labels.height(); ++y) {
    for (int x{0}; x < labels.width(); ++x) {
      if (labels(x, y) != 0 || !is_active(world, config, x, y)) continue;
      const int label{static_cast<int>(clusters.size()) + 1};
      cells.assign(1, {x, y});
      labels(x, y) = label;
      grow(world, config, label, labels, cells);
      if (static_cast<int>(cells.size()) >= config.cells_min) {
        clusters.push_back(describe(world, cells));
      } else {
        for (const Cell cell : cells) labels(cell.x, cell.y) = -1;
      }
    }
  }
  std::replace(labels.begin(), labels.end(), -1, 0);
}

}  // namespace stereogrid
