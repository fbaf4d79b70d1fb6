// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "world/chassis.hpp"

#include <cmath>

#include "world/angle.hpp"

namespace stereogrid::scenes {
namespace {

Vector3 unit(Vector3 v) {
  return (1 / std::sqrt(dot(v, v))) * v;
}

}  // namespace

Frame3 standing_at(const HeightField& ground, const Pose2& pose, const Wheels& wheels) {
  const Direction heading{direction_of(pose.yaw_rad)};
  Frame3 frame{
      {pose.x_m, pose.y_m, 0}, {heading.cosine, heading.sine, 0}, {-heading.sine, heading.cosine, 0}, {0, 0, 1}};
  if (ground.is_flat()) return frame;
  const auto contact = [&](double ahead, double left) {
    return ground.height_at(pose.x_m + ahead * heading.cosine - left * heading.sine,
                            pose.y_m + ahead * heading.sine + left * heading.cosine);
  };
  const double track{wheels.half_track_m};
  const double front_left{contact(wheels.front_m, track)};
  const double front_right{contact(wheels.front_m, -track)};
  const double rear_left{contact(-wheels.rear_m, track)};
  const double rear_right{contact(-wheels.rear_m, -track)};
  const double base{wheels.front_m + wheels.rear_m};
  const double climb{(front_left + front_right - rear_left - rear_right) / (2 * base)};
  const double bank{(front_left + rear_left - front_right - rear_right) / (4 * track)};
  const double middle{(front_left + front_right + rear_left + rear_right) / 4};
  frame.origin.z = middle - climb * (wheels.front_m - wheels.rear_m) / 2;
  if (climb == 0 && bank == 0) return frame;
  const Vector3 ahead{frame.forward + climb * frame.up};
  const Vector3 left{frame.left + bank * frame.up};
  const Vector3 normal{frame.up - climb * frame.forward - bank * frame.left};
  frame.forward = unit(ahead);
  frame.up = unit(normal);
  frame.left = unit(left - dot(left, frame.forward) * frame.forward);
  return frame;
}

}  // namespace stereogrid::scenes
