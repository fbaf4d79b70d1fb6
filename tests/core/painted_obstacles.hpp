// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "motion/scene_flow.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "support.hpp"

namespace stereogrid::test {

/// Disparities of upright surfaces, painted from far to near: a level camera 1.2 m high, f·b = 80 px·m.
struct PaintedObstacles {
  static constexpr int disparities{48};

  static Rig rig() { return {256, 160, 200, 128, 80, 0.4, 1.2, 0, 0}; }

  /// Between right_m and left_m of the vehicle frame's y, and between two heights.
  PaintedObstacles& wall(double x_m, double right_m, double left_m, double from_m = 0, double to_m = 1.5) {
    for (int u{column(x_m, left_m)}; u < column(x_m, right_m); ++u) strip(u, x_m, from_m, to_m);
    return *this;
  }
  /// Along the vehicle's x, at y_m.
  PaintedObstacles& side(double near_m, double far_m, double y_m) {
    const int first{column(far_m, y_m)};
    const int last{column(near_m, y_m)};
    const int step{last > first ? 1 : -1};
    for (int u{first}; u != last; u += step) {
      const double x_m{200 * y_m / (128 - (u + 0.5))};
      strip(u, x_m, 0, 1.5);
    }
    return *this;
  }
  void strip(int u, double x_m, double from_m, double to_m) {
    if (u < 0 || u >= 256) return;
    const auto row = [x_m](double height_m) {
      return static_cast<int>(std::lround(80 + 200 * (1.2 - height_m) / x_m));
    };
    for (int v{std::max(row(to_m), 0)}; v < std::min(row(from_m), 160); ++v) {
      disparity(u, v) = static_cast<float>(80 / x_m);
    }
  }
  static int column(double x_m, double y_m) { return static_cast<int>(std::lround(128 - 200 * y_m / x_m)); }

  Image<float> disparity{256, 160};
};

/// All in one go.
inline constexpr auto in_one = [](int count, const auto& work) { work(0, count); };

inline ClusterWorkspace obstacle_space() {
  return {PaintedObstacles::rig(), PaintedObstacles::disparities};
}

template <class ForRanges = decltype(in_one)>
std::vector<ColumnNode> nodes_in(View<const float> obstacle, const Ground& ground,
                                 const ForRanges& for_ranges = in_one) {
  ColumnCounter columns{PaintedObstacles::rig(), UDisparityConfig{}, PaintedObstacles::disparities};
  const std::span<const ColumnNode> nodes{columns.find(obstacle, ground, {}, for_ranges)};
  return {nodes.begin(), nodes.end()};
}

/// Nothing known but that nothing moves: 30 × 20 m in cells of 0.2 m, ahead of the origin.
inline GridLayers still_world() {
  GridLayers world;
  world.geometry = {0, -10, 0.2, 150, 100};
  world.occupancy = Image<float>{150, 100, 0.9f};
  world.velocity_x = world.velocity_y = world.moving = Image<float>{150, 100};
  world.age_s = Image<float>{150, 100, 0.0f};
  return world;
}

inline FlowVector vector_at(Point2 place, Point2 velocity, double sigma_mps = 0.5) {
  const double variance{sigma_mps * sigma_mps};
  return {place, {0.01, 0, 0.01}, velocity, {variance, 0, variance}};
}

/// Finds the clusters of a frame as FramePipeline does.
inline void find_clusters(View<const float> obstacle, const Ground& ground, const GridLayers& world,
                          const Pose2& world_from_vehicle, const std::vector<FlowVector>& vectors,
                          ClusterWorkspace& space) {
  find_segments(nodes_in(obstacle, ground), ground, {}, world_from_vehicle, vectors, in_one, space);
  make_clusters(world, world_from_vehicle, {}, space);
}

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
