// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/evaluation/ray_fan.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid::evaluation {

/// Inverse sensor model of a lidar (Thrun, Burgard, Fox: Probabilistic Robotics, table 9.2), summed over the returns of
/// a sweep.
struct LidarModelParameters {
  LogOddsParameters log_odds{.height_min_m = 0.3, .hit = 0.75, .any_pass = 2, .pass = 0};
  double beam_rad{0.0035};  ///< opening B
};
/// Heights are above the plane that lidar_labels fits, with the same `rig` and `camera_height_m`. `lidar`: where the
/// sensor is in the camera's frame.
[[nodiscard]] STEREOGRID_EXPORT Image<float> lidar_grid(std::span<const CameraPoint> points, const CameraPoint& lidar,
                                                        const Rig& rig, const GridGeometry& grid,
                                                        double camera_height_m = kitti_camera_height_m,
                                                        const LidarModelParameters& parameters = {});

}  // namespace stereogrid::evaluation
