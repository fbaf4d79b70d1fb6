// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::stereo_msgs {

struct DisparityImage {
  STEREOGRID_MESSAGE("stereo_msgs/msg/DisparityImage", header, image, f, t, valid_window, min_disparity, max_disparity,
                     delta_d);

  std_msgs::Header header;
  sensor_msgs::Image image;  ///< 32FC1, px; below min_disparity: none
  float f{0};                ///< px
  float t{0};                ///< m, baseline
  sensor_msgs::RegionOfInterest valid_window;
  float min_disparity{0};  ///< px
  float max_disparity{0};  ///< px
  float delta_d{0};        ///< px, smallest step
};

}  // namespace stereogrid::messages::stereo_msgs
