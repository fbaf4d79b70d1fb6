// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <geometry_msgs/msg/transform.hpp>
#include <sensor_msgs/msg/camera_info.hpp>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/ros_camera.hpp"

namespace stereogrid_ros {

/// Throws stereogrid::InputError: binning, or a region of interest.
[[nodiscard]] stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name);

/// Position and heading of the camera on the ground. Throws stereogrid::InputError: a quaternion whose length differs
/// from 1 by more than 1 %.
[[nodiscard]] stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera);

/// Sets the extrinsics of `rig`. Throws stereogrid::InputError: the camera is not above z = 0 of the base frame, or
/// points straight up or down; a quaternion whose length differs from 1 by more than 1 %.
void set_extrinsics(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera);

}  // namespace stereogrid_ros
