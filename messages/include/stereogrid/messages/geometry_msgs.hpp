// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::geometry_msgs {

/// m.
struct Point {
  STEREOGRID_MESSAGE("geometry_msgs/msg/Point", x, y, z);

  double x{0};
  double y{0};
  double z{0};
};

struct Vector3 {
  STEREOGRID_MESSAGE("geometry_msgs/msg/Vector3", x, y, z);

  double x{0};
  double y{0};
  double z{0};
};

struct Quaternion {
  STEREOGRID_MESSAGE("geometry_msgs/msg/Quaternion", x, y, z, w);

  double x{0};
  double y{0};
  double z{0};
  double w{1};
};

struct Pose {
  STEREOGRID_MESSAGE("geometry_msgs/msg/Pose", position, orientation);

  Point position;
  Quaternion orientation;
};

struct PoseWithCovariance {
  STEREOGRID_MESSAGE("geometry_msgs/msg/PoseWithCovariance", pose, covariance);

  Pose pose;
  std::array<double, 36> covariance{};  ///< row-major: x, y, z, rotations about x, y, z
};

struct Twist {
  STEREOGRID_MESSAGE("geometry_msgs/msg/Twist", linear, angular);

  Vector3 linear;   ///< m/s
  Vector3 angular;  ///< rad/s
};

struct TwistWithCovariance {
  STEREOGRID_MESSAGE("geometry_msgs/msg/TwistWithCovariance", twist, covariance);

  Twist twist;
  std::array<double, 36> covariance{};
};

struct Transform {
  STEREOGRID_MESSAGE("geometry_msgs/msg/Transform", translation, rotation);

  Vector3 translation;  ///< m
  Quaternion rotation;
};

/// Takes points of child_frame_id to header.frame_id.
struct TransformStamped {
  STEREOGRID_MESSAGE("geometry_msgs/msg/TransformStamped", header, child_frame_id, transform);

  std_msgs::Header header;
  std::string child_frame_id;
  Transform transform;
};

}  // namespace stereogrid::messages::geometry_msgs

namespace stereogrid::messages::tf2_msgs {

struct TFMessage {
  STEREOGRID_MESSAGE("tf2_msgs/msg/TFMessage", transforms);

  std::vector<geometry_msgs::TransformStamped> transforms;
};

}  // namespace stereogrid::messages::tf2_msgs
