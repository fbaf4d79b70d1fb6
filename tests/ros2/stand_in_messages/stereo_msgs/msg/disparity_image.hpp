// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/header.hpp>

namespace stereo_msgs::msg {

struct DisparityImage {
  std_msgs::msg::Header header;
  sensor_msgs::msg::Image image;
  float f{0};
  float t{0};
  float min_disparity{0};
  float max_disparity{0};
  float delta_d{0};
};

}  // namespace stereo_msgs::msg
