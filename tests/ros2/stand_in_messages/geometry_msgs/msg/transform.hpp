// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <std_msgs/msg/header.hpp>

namespace geometry_msgs::msg {

struct Vector3 {
  double x{0};
  double y{0};
  double z{0};
};

struct Quaternion {
  double x{0};
  double y{0};
  double z{0};
  double w{1};
};

struct Transform {
  Vector3 translation;
  Quaternion rotation;
};

struct TransformStamped {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  Transform transform;
};

}  // namespace geometry_msgs::msg
