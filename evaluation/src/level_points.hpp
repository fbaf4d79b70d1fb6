// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "road_plane.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {

/// From the frame of a camera that is mounted as a rig says to that of the same camera turned level about the baseline,
/// as LevelMapping turns its images: there z is the vehicle's x, and −x its y.
class LevelFrame {
 public:
  explicit LevelFrame(const Rig& rig);

  [[nodiscard]] CameraPoint operator()(const CameraPoint& point) const {
    return {point.x_m, cos_ * point.y_m + sin_ * point.z_m, cos_ * point.z_m - sin_ * point.y_m};
  }
  [[nodiscard]] std::vector<CameraPoint> operator()(std::span<const CameraPoint> points) const;
  /// Road according to the extrinsics, `camera_height_m` below the camera.
  [[nodiscard]] RoadPlane road(double camera_height_m) const;

 private:
  Rig rig_;
  double sin_;
  double cos_;
};

}  // namespace stereogrid::evaluation
