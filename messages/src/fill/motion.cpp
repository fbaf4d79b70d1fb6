// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "fill/fill.hpp"

namespace stereogrid::messages {
namespace {

using geometry_msgs::Quaternion;

// First b, then a.
Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

}  // namespace

builtin_interfaces::Time time_of(std::int64_t stamp_ns) {
  constexpr std::int64_t second_ns{1'000'000'000};
  const std::int64_t nanosec{(stamp_ns % second_ns + second_ns) % second_ns};
  // not stamp_ns - nanosec, which may lie below the range
  const std::int64_t sec{stamp_ns / second_ns - (stamp_ns % second_ns < 0 ? 1 : 0)};
  using Range = std::numeric_limits<std::int32_t>;
  return {static_cast<std::int32_t>(std::clamp<std::int64_t>(sec, Range::min(), Range::max())),
          static_cast<std::uint32_t>(nanosec)};
}

Quaternion rotation_about_z(double yaw_rad) {
  return {0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
}

// The camera's z becomes the vehicle's x, its x becomes −y, its y becomes −z; then roll (right side down) about the
// vehicle's x, then pitch (down) about its y. It is the inverse of the road's direction in the camera
// (docs/method.md §1.2): (cos pitch · sin roll, cos pitch · cos roll, sin pitch).
geometry_msgs::Transform vehicle_from_camera(const Rig& rig) {
  const Quaternion level{-0.5, 0.5, -0.5, 0.5};
  const Quaternion roll{std::sin(rig.camera_roll_rad / 2), 0, 0, std::cos(rig.camera_roll_rad / 2)};
  const Quaternion pitch{0, std::sin(rig.camera_pitch_rad / 2), 0, std::cos(rig.camera_pitch_rad / 2)};
  return {{0, 0, rig.camera_height_m}, product(pitch, product(roll, level))};
}

geometry_msgs::Transform world_from_vehicle(const Pose2& pose) {
  return {{pose.x_m, pose.y_m, 0}, rotation_about_z(pose.yaw_rad)};
}

// Covariances remain 0: the accuracy of poses is unknown.
void fill(nav_msgs::Odometry& message, const Pose2& world_from_vehicle, const Pose2& moved, double dt_s) {
  message.pose.pose = {{world_from_vehicle.x_m, world_from_vehicle.y_m, 0},
                       rotation_about_z(world_from_vehicle.yaw_rad)};
  // in the frame of the mean heading
  const Pose2 halfway{0, 0, -moved.yaw_rad / 2};
  const Point2 way{halfway * Point2{moved.x_m, moved.y_m}};
  message.twist.twist.linear = {way.x / dt_s, way.y / dt_s, 0};
  message.twist.twist.angular = {0, 0, moved.yaw_rad / dt_s};
}

}  // namespace stereogrid::messages
