// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace geometry_msgs::msg
