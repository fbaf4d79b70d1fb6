// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::geometry_msgs {

/// m.
struct Point {
  static constexpr std::string_view type_name{"geometry_msgs/msg/Point"};

  double x{0};
  double y{0};
  double z{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("z", self.z);
  }
};

struct Vector3 {
  static constexpr std::string_view type_name{"geometry_msgs/msg/Vector3"};

  double x{0};
  double y{0};
  double z{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("z", self.z);
  }
};

struct Quaternion {
  static constexpr std::string_view type_name{"geometry_msgs/msg/Quaternion"};

  double x{0};
  double y{0};
  double z{0};
  double w{1};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("z", self.z);
    visit("w", self.w);
  }
};

struct Pose {
  static constexpr std::string_view type_name{"geometry_msgs/msg/Pose"};

  Point position;
  Quaternion orientation;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("position", self.position);
    visit("orientation", self.orientation);
  }
};

struct PoseWithCovariance {
  static constexpr std::string_view type_name{"geometry_msgs/msg/PoseWithCovariance"};

  Pose pose;
  std::array<double, 36> covariance{};  ///< row-major: x, y, z, rotations about x, y, z

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("pose", self.pose);
    visit("covariance", self.covariance);
  }
};

struct Twist {
  static constexpr std::string_view type_name{"geometry_msgs/msg/Twist"};

  Vector3 linear;   ///< m/s
  Vector3 angular;  ///< rad/s

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("linear", self.linear);
    visit("angular", self.angular);
  }
};

struct TwistWithCovariance {
  static constexpr std::string_view type_name{"geometry_msgs/msg/TwistWithCovariance"};

  Twist twist;
  std::array<double, 36> covariance{};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("twist", self.twist);
    visit("covariance", self.covariance);
  }
};

struct Transform {
  static constexpr std::string_view type_name{"geometry_msgs/msg/Transform"};

  Vector3 translation;  ///< m
  Quaternion rotation;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("translation", self.translation);
    visit("rotation", self.rotation);
  }
};

/// Takes points of child_frame_id to header.frame_id.
struct TransformStamped {
  static constexpr std::string_view type_name{"geometry_msgs/msg/TransformStamped"};

  std_msgs::Header header;
  std::string child_frame_id;
  Transform transform;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("child_frame_id", self.child_frame_id);
    visit("transform", self.transform);
  }
};

}  // namespace stereogrid::messages::geometry_msgs
