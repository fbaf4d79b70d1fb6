// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "connect/ros2_node.hpp"
#include "input.hpp"
#include "live/live_input.hpp"

namespace stereogrid::app {

/// True if SOURCE is "ros2:/NAMESPACE", or "ros2:" for any namespace.
[[nodiscard]] bool is_ros2(const std::string& source);

/// Opens two cameras, or a camera with depth, on the network. Waits until both topics have images, and CameraInfo if no
/// calibration is given; waiting is reported. Throws ConfigError: options that do not fit; DeviceError; InputError: no
/// pair of cameras. Sets the options in `ros2` that follow from the poses.
[[nodiscard]] LiveInput open_ros2_input(const InputOptions& options, Ros2Options& ros2);

}  // namespace stereogrid::app
