// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "motion/scene_flow.hpp"
#include "obstacles/segmentation/clusters.hpp"

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
  return {PaintedObstacles::rig(), UDisparityConfig{}, PaintedObstacles::disparities};
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
template <class ForRanges>
void find_clusters(View<const float> obstacle, const Ground& ground, const GridLayers& world,
                   const Pose2& world_from_vehicle, const std::vector<FlowVector>& vectors, const ForRanges& for_ranges,
                   ClusterWorkspace& space) {
  find_segments(obstacle, ground, {}, world_from_vehicle, vectors, for_ranges, space);
  make_clusters(world, world_from_vehicle, vectors, {}, space);
}

}  // namespace stereogrid::test
