// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <string>

#include <geometry_msgs/msg/transform.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <stereo_msgs/msg/disparity_image.hpp>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/io/ros_camera.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid_ros {

/// View of the message's pixels. 8-bit Bayer patterns are converted to grey values in `grey`. `name`: for errors.
/// Throws stereogrid::InputError: unsupported encoding, fewer bytes than the size requires.
[[nodiscard]] stereogrid::PixelView pixels_of(const sensor_msgs::msg::Image& image, const std::string& name,
                                              cv::Mat& grey);

/// Depth, m; 0: none. Image: 16UC1 in mm, 32FC1 in m (REP 118); DisparityImage: f·T/d within its limits. Throws
/// stereogrid::InputError: unsupported encoding, fewer bytes than the size requires, no f or T.
[[nodiscard]] stereogrid::Image<float> depth_of(const sensor_msgs::msg::Image& image);
[[nodiscard]] stereogrid::Image<float> depth_of(const stereo_msgs::msg::DisparityImage& disparity);

/// Throws stereogrid::InputError: binning, or a region of interest.
[[nodiscard]] stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name);

/// Position and heading of the camera on the ground. Throws stereogrid::InputError: a quaternion whose length differs
/// from 1 by more than 1 %.
[[nodiscard]] stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera);

/// Sets the extrinsics of `rig`. Throws stereogrid::InputError: the camera is not above z = 0 of the base frame, or
/// points straight up or down; a quaternion whose length differs from 1 by more than 1 %.
void set_extrinsics(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera);

}  // namespace stereogrid_ros
