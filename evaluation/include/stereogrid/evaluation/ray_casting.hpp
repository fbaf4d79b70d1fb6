// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>

#include "stereogrid/evaluation/baselines.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid::evaluation {

/// Log-odds that points and rays give, as in OctoMap and the layers of Nav2.
struct LogOddsParameters {
  double height_min_m{0.25};  ///< points between these heights are hits
  double height_max_m{1.8};
  double road_m{0.2};    ///< points within this of the road end free rays
  double any_hit{1.5};   ///< log-odds of a cell with hits
  double hit{0.1};       ///< and of each of them
  double any_pass{1};    ///< log-odds, taken away, of a cell without hits that rays go through
  double pass{0.001};    ///< and of each ray, with hits or without
  double points_min{1};  ///< fewer hits are none
  double lowest{-5};     ///< log-odds are kept between these
  double highest{5};
};

/// Point-cloud ray casting: obstacle points are hits, road points free ends, cells on the way are cleared by a grid
/// traversal; a hit outweighs what passes above it.
[[nodiscard]] STEREOGRID_EXPORT Image<float> ray_casting_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                                              const LogOddsParameters& parameters = {});

/// The same over time: the log-odds of all frames summed in the world, which is taken to stand still.
class STEREOGRID_EXPORT LogOddsMap {
 public:
  explicit LogOddsMap(double weight_of_frame = 0.8,
                      const LogOddsParameters& parameters = {.hit = 0.6, .any_pass = 0.5, .lowest = -3, .highest = 4});

  /// Adds a frame and gives the map as it lies under a grid in the vehicle frame.
  [[nodiscard]] Image<float> update(const DisparityFrame& frame, const Pose2& world_from_vehicle,
                                    const GridGeometry& grid);

 private:
  double weight_;
  LogOddsParameters parameters_;
  std::unordered_map<std::int64_t, float> cells_;
};

/// Inverse sensor model of a lidar (Thrun, Burgard, Fox: Probabilistic Robotics, table 9.2), summed over the returns of
/// a sweep.
struct LidarModelParameters {
  LogOddsParameters log_odds{.height_min_m = 0.3, .hit = 0.75, .any_pass = 2, .pass = 0};
  double beam_rad{0.0035};  ///< opening B
};
/// Heights are above the plane that lidar_labels fits, with the same `camera_height_m`. `lidar`: where the sensor is in
/// the camera's frame.
[[nodiscard]] STEREOGRID_EXPORT Image<float> lidar_grid(std::span<const CameraPoint> points, const CameraPoint& lidar,
                                                        const GridGeometry& grid,
                                                        double camera_height_m = kitti_camera_height_m,
                                                        const LidarModelParameters& parameters = {});

}  // namespace stereogrid::evaluation
