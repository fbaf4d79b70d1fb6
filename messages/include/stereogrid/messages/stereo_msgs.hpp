// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::stereo_msgs {

struct DisparityImage {
  static constexpr std::string_view type_name{"stereo_msgs/msg/DisparityImage"};

  std_msgs::Header header;
  sensor_msgs::Image image;  ///< 32FC1, px; below min_disparity: none
  float f{0};                ///< px
  float t{0};                ///< m, baseline
  sensor_msgs::RegionOfInterest valid_window;
  float min_disparity{0};  ///< px
  float max_disparity{0};  ///< px
  float delta_d{0};        ///< px, smallest step

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("image", self.image);
    visit("f", self.f);
    visit("t", self.t);
    visit("valid_window", self.valid_window);
    visit("min_disparity", self.min_disparity);
    visit("max_disparity", self.max_disparity);
    visit("delta_d", self.delta_d);
  }
};

}  // namespace stereogrid::messages::stereo_msgs
