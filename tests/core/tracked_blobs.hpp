// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "obstacles/tracking/tracking.hpp"
#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {

inline TrackingConfig plain_config() {
  TrackingConfig config;
  config.confirm_frames = 3;
  config.coast_s = 1.0;
  return config;
}

/// A filtered grid of 60 × 50 cells of 0.2 m, from (−2, −5), all free.
struct GroundSeenFree {
  GroundSeenFree() {
    layers.geometry = {-2, -5, 0.2, 60, 50};
    layers.occupancy = Image<float>{60, 50, 0.1f};
    layers.age_s = Image<float>{60, 50, 0.0f};
  }

  GridLayers layers;
};

inline void update(Tracker& tracker, const GroundSeenFree& world, const std::vector<Cluster>& clusters, double dt_s) {
  tracker.update(world.layers, clusters, {}, dt_s);
}

inline Cluster blob_at(double x, double y, Point2 velocity = {}) {
  Cluster cluster;
  cluster.pixels = 60;
  cluster.centre = {x, y};
  cluster.velocity = velocity;
  cluster.occupancy = 0.9;
  cluster.length_m = 0.6;
  cluster.width_m = 0.4;
  for (const Point2 corner : {Point2{-0.3, 0.2}, {-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}}) {
    cluster.outline.push_back({x + corner.x, y + corner.y});
  }
  cluster.bounds = {{x - 0.3, y - 0.2}, {x + 0.3, y + 0.2}};
  return cluster;
}

/// Hides everything ahead.
inline Cluster screen() {
  Cluster cluster{blob_at(1, 0)};
  cluster.outline = {{0.9, 1}, {0.9, -1}, {1.1, -1}, {1.1, 1}};
  cluster.bounds = {{0.9, -1}, {1.1, 1}};
  return cluster;
}

inline std::vector<Obstacle> report_of(const Tracker& tracker, const Pose2& world_from_vehicle = {},
                                       const GridGeometry& vehicle_grid = {-50, -50, 1, 100, 100}) {
  std::vector<Obstacle> obstacles(2);
  tracker.report(world_from_vehicle, vehicle_grid, obstacles);
  return obstacles;
}

/// A box with points followed on it, from its sides along the axes.
inline Cluster box_between(Point2 least, Point2 most, Point2 velocity, double sigma_mps) {
  Cluster cluster{blob_at((least.x + most.x) / 2, (least.y + most.y) / 2, velocity)};
  cluster.outline = {least, {most.x, least.y}, most, {least.x, most.y}};
  cluster.bounds = {least, most};
  cluster.length_m = most.x - least.x;
  cluster.width_m = most.y - least.y;
  cluster.velocity_covariance = {sigma_mps * sigma_mps, 0, sigma_mps * sigma_mps};
  return cluster;
}

/// A tracker and its world. `occupancy`: of all cells.
struct TrackedBlobs {
  TrackedBlobs() = default;
  explicit TrackedBlobs(float occupancy) { world.layers.occupancy.fill(occupancy); }

  void update(const std::vector<Cluster>& clusters, double dt_s) { test::update(tracker, world, clusters, dt_s); }
  [[nodiscard]] std::vector<Obstacle> report(const Pose2& world_from_vehicle = {}) const {
    return report_of(tracker, world_from_vehicle);
  }

  GroundSeenFree world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
};

inline GroundSeenFree wide_world() {
  GroundSeenFree world;
  world.layers.geometry = {-30, -30, 0.5, 120, 120};
  world.layers.occupancy = Image<float>{120, 120, 0.5f};
  world.layers.age_s = Image<float>{120, 120, 0.0f};
  return world;
}

}  // namespace stereogrid::test
