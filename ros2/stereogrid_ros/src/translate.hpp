// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <string>

#include <geometry_msgs/msg/transform.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/ros_camera.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid_ros {

/// The message's pixels, where they lie; 8-bit Bayer patterns as grey values, which `grey` stores. `name`: for errors.
/// Throws stereogrid::InputError: an encoding that is not read, fewer bytes than the size asks for.
[[nodiscard]] stereogrid::PixelView pixels_of(const sensor_msgs::msg::Image& image, const std::string& name,
                                              cv::Mat& grey);

/// Throws stereogrid::InputError: a part of the camera's image (binning, region of interest).
[[nodiscard]] stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name);

/// Position and heading of the camera on the ground. Throws stereogrid::InputError: a quaternion of another length than
/// 1, by more than 1 %.
[[nodiscard]] stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera);

/// Sets height, pitch and roll of a camera whose optical frame is that. Throws stereogrid::InputError: it is not above
/// z = 0, or looks straight up or down; a quaternion of another length than 1, by more than 1 %.
void set_mounting(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera);

}  // namespace stereogrid_ros
