// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Copyright 2026 The stereogrid authors
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.
#pragma once

#include <set>
#include <string>
#include <vector>

#include <geometry_msgs/msg/transform.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <sensor_msgs/msg/camera_info.hpp>

#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid_ros {

/// Parameters that may change while the node is configured, from the next frame on.
struct Thresholds {
  double pair_tolerance_s{0.01};
  double transform_tolerance_s{0.2};
  double points_voxel_m{0.1};
};

/// The node's parameters (config/stereo_grid.yaml).
struct Settings {
  stereogrid::Config config;
  stereogrid::PipelineOptions pipeline;
  stereogrid::messages::FrameMessagesOptions messages;
  std::vector<std::string> cameras;   ///< namespaces of several stereo pairs; empty: one, in the node's own
  std::string input;                  ///< stereo, depth, disparity
  std::string image_transport;        ///< raw, compressed
  std::string depth_image_transport;  ///< raw, compressedDepth, compressed
  bool are_rectified{true};
  std::string global_frame;      ///< frame of the poses
  std::string robot_base_frame;  ///< frame of the extrinsics: its z = 0 is the road
  std::string poses;             ///< tf, images, none
  Thresholds thresholds;
  std::set<std::string> names;  ///< names of all parameters that were read
};

/// Parameter autostart, declared if it is not yet. Throws stereogrid::ConfigError: not a boolean.
[[nodiscard]] bool is_autostarted(rclcpp_lifecycle::LifecycleNode& node);

/// Each parameter of stereogrid::Config as "group.name", and the node's own ones; those that are not yet declared are
/// declared with range and description. Throws stereogrid::ConfigError: all invalid values.
[[nodiscard]] Settings read_settings(rclcpp_lifecycle::LifecycleNode& node);

/// Sets one of the thresholds; false: `parameter` is none of them. Throws stereogrid::ConfigError: its value.
bool set_threshold(Thresholds& thresholds, const rclcpp::Parameter& parameter);

/// Throws stereogrid::InputError: binning, or a region of interest.
[[nodiscard]] stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name);

/// Position and heading of the camera on the ground. Throws stereogrid::InputError: a quaternion whose length differs
/// from 1 by more than 1 %.
[[nodiscard]] stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera);

/// Sets the extrinsics of `rig`. Throws stereogrid::InputError: the camera is not above z = 0 of the base frame, or
/// points straight up or down; a quaternion whose length differs from 1 by more than 1 %.
void set_extrinsics(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera);

}  // namespace stereogrid_ros
