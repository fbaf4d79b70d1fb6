// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/scan.hpp"

namespace stereogrid::app::figures {

/// A lidar return in the vehicle frame; height above the road that `Ground` describes.
struct LidarPoint {
  double x_m{0};
  double y_m{0};
  double height_m{0};
};

/// A sweep in the vehicle frame. `ground` as a frame's result has it: of the camera turned level where the rig's pitch
/// is above 1°.
[[nodiscard]] std::vector<LidarPoint> in_vehicle(const std::vector<io::ScanPoint>& scan,
                                                 const io::Transform& camera_from_velodyne, const Rig& rig,
                                                 const Ground& ground);

}  // namespace stereogrid::app::figures
