// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "stereogrid/error.hpp"
#include "stereogrid/io/poses.hpp"

namespace stereogrid_ros {
namespace {

using stereogrid::InputError;

/// 3 × 4, row-major. Throws InputError: the rotation is not of length 1.
std::array<double, 12> matrix_of(const geometry_msgs::msg::Transform& transform) {
  const auto& q{transform.rotation};
  const auto unit{stereogrid::io::unit_quaternion({q.x, q.y, q.z, q.w})};
  if (!unit) {
    throw InputError{"TF",
                     "a rotation is a quaternion of length " +
                         std::to_string(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)) +
                         " (allowed 0.99 to 1.01).",
                     "Correct what publishes the transforms."};
  }
  const auto& [x, y, z, w]{*unit};
  const auto& t{transform.translation};
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     t.x,
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     t.y,
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), t.z};
}

}  // namespace

stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name) {
  if (info.binning_x > 1 || info.binning_y > 1 || info.roi.x_offset != 0 || info.roi.y_offset != 0) {
    throw InputError{name, "images with binning or a roi are unsupported.", "Publish whole images."};
  }
  stereogrid::io::RosCamera camera{
      name,  static_cast<int>(info.width), static_cast<int>(info.height), info.distortion_model, info.d, info.k, info.r,
      info.p};
  if (camera.d.empty() && camera.distortion_model != "equidistant") {  // simulators
    camera.distortion_model = "plumb_bob";
    camera.d.resize(5);
  }
  return camera;
}

stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera) {
  const std::array<double, 12> m{matrix_of(world_from_camera)};
  return {m[3], m[7], std::atan2(m[6], m[2])};
}

void set_extrinsics(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera) {
  const std::array<double, 12> m{matrix_of(base_from_camera)};
  const double right_z{m[8]};
  const double down_z{m[9]};
  const double forward_z{m[10]};
  rig.camera_height_m = m[11];
  rig.camera_pitch_rad = std::asin(std::clamp(-forward_z, -1.0, 1.0));
  rig.camera_roll_rad = std::atan2(-right_z, -down_z);
  if (rig.camera_height_m > 0 && std::abs(forward_z) < 0.99) return;
  throw InputError{"TF", "the left camera is not above z = 0 of the base frame, or points straight up or down.",
                   "Set robot_base_frame to a frame on the road (base_footprint), or to \"\"."};
}

}  // namespace stereogrid_ros
