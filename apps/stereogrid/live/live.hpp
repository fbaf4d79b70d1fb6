// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "cli/config_options.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
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

struct LiveOptions {
  LiveInputOptions input;
  ConfigOptions config;
  DeviceOptions device;
  std::vector<double> predict_s;
  MessageOptions messages;
  PageOptions page;
};

/// `stereogrid live`. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int live(const LiveOptions& options);

/// True if SOURCE is "ros2:/NAMESPACE", or "ros2:" for any namespace.
[[nodiscard]] bool is_ros2(const std::string& source);

/// Opens two cameras, or a camera with depth, on the network. Waits until both topics have images, and CameraInfo if no
/// calibration is given; waiting is reported. Throws ConfigError: options that do not fit; DeviceError; InputError: no
/// pair of cameras. Sets the options in `ros2` that follow from the poses.
[[nodiscard]] LiveInput open_ros2_input(const InputOptions& options, Ros2Options& ros2);

/// systemd, where it has started this program as a service of Type=notify (sd_notify(3): the socket that NOTIFY_SOCKET
/// names). Without one nothing happens.
class ServiceManager {
 public:
  ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;
  ~ServiceManager();

  void notify_ready();
  /// Sends the watchdog notification, at most once a second; call it more often.
  void notify_alive();

 private:
  void send(const std::string& words) const;

  int socket_{-1};
  std::chrono::steady_clock::time_point reported_{};
};

}  // namespace stereogrid::app
