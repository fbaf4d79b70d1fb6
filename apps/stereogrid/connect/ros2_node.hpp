// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stereogrid/dds/node.hpp"

namespace stereogrid::app {

class Command;

/// This program as a node of ROS 2, as its user says.
struct Ros2Options {
  bool publishes{false};
  std::string node{"stereo_grid"};
  std::vector<std::string> remappings{};
  std::string distro{};               ///< "": that of ROS_DISTRO, else of the peers
  bool uses_sim_time{false};          ///< live sources only
  bool leaves_tf{false};              ///< to others: /tf is not published
  std::vector<std::string> frames{};  ///< names of the world and vehicle frame; none: odom, base_link
  std::vector<double> camera_at{};    ///< x, y (m) and heading (°) of the left camera in the frame of its poses

  friend bool operator==(const Ros2Options&, const Ros2Options&) = default;
};

void add_ros2_options(Command command, Ros2Options& options);

/// Throws ConfigError: something is said of a node, but there is none.
void refuse_without_node(const Ros2Options& options);

/// Without opening anything. Throws as open_ros2_node().
void check(const Ros2Options& options);

/// Node of the program: shared by all users, with the options of the first one.
///
/// Loads libstereogrid_dds.so. Search order: beside this program, in the folder of `cmake --install`, in the paths of
/// the loader; the environment variable STEREOGRID_DDS_LIBRARY names another file. Warnings go to the log. Throws
/// ConfigError; DeviceError, which names the missing part.
[[nodiscard]] std::shared_ptr<dds::Node> open_ros2_node(const Ros2Options& options);

}  // namespace stereogrid::app
