// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// One camera as ROS calibrates it (sensor_msgs/CameraInfo, REP 104). Matrices are row-major, lengths in pixels.
struct RosCamera {
  std::string name;  ///< source, for messages
  int width_px{0};   ///< size of the calibration's images
  int height_px{0};
  std::string distortion_model;  ///< plumb_bob, rational_polynomial or equidistant; "": plumb_bob
  std::vector<double> d;         ///< as many as the model has: 5 (or 4), 8 (or OpenCV's 12 or 14), 4
  std::array<double, 9> k{};     ///< camera matrix, before rectification
  std::array<double, 9> r{};     ///< takes points of the camera to those of the rectified camera
  std::array<double, 12> p{};    ///< projection after rectification; of the right camera p[3] = −p[0] · baseline (m)
};

/// Calibration from two messages. `are_rectified`: P applies to the images, and K, D and R are ignored. Otherwise they
/// are raw, and `raw` of the result describes the rectification, unless none is needed. Extrinsics are defaults: height
/// 1.65 m, angles 0. Throws InputError: no calibrated pair, non-finite numbers, an unsupported distortion model.
[[nodiscard]] STEREOGRID_EXPORT Calibration ros_calibration(const RosCamera& left, const RosCamera& right,
                                                            bool are_rectified);

}  // namespace stereogrid::io
