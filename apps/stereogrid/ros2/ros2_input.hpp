// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "connect/ros2_node.hpp"
#include "input.hpp"
#include "live/live_input.hpp"

namespace stereogrid::app {

/// Is SOURCE "ros2:/NAMESPACE", or "ros2:" for all there is?
[[nodiscard]] bool is_ros2(const std::string& source);

/// Cameras, or a camera with depth, on the network. Waits until both topics have images, and CameraInfo where no
/// calibration is given; what it waits for, it tells. Throws ConfigError: options that do not fit; DeviceError;
/// InputError: no pair of cameras. What follows from the poses for the messages is set in `ros2`.
[[nodiscard]] LiveInput open_ros2_input(const InputOptions& options, Ros2Options& ros2);

}  // namespace stereogrid::app
