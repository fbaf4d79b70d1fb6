// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "connect/ros2_node.hpp"
#include "input.hpp"
#include "stereogrid/capture/live_source.hpp"

namespace stereogrid::app {

struct LiveInputOptions {
  InputOptions input;  ///< whose paths are SOURCE
  bool loops{false};
  double speed{1};
};

/// Opened SOURCE.
struct LiveInput {
  Input recording{};  ///< with a source where it is one; has to live longer than `source`
  std::unique_ptr<capture::LiveSource> source;
  std::string kind;
  PoseSource poses{PoseSource::odometry};
  bool in_world_of_poses{false};  ///< PipelineOptions::in_world_of_poses
  Image<std::uint8_t> mask{};
};

/// `ros2`: for a SOURCE there. Throws ConfigError, InputError, DeviceError.
[[nodiscard]] LiveInput open_live_input(const LiveInputOptions& options, Ros2Options& ros2);

}  // namespace stereogrid::app
