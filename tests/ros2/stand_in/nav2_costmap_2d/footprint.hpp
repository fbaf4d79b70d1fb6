// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <geometry_msgs/msg/point.hpp>
#include <vector>

namespace nav2_costmap_2d {

inline void transformFootprint(double x, double y, double theta,
                               const std::vector<geometry_msgs::msg::Point>& footprint,
                               std::vector<geometry_msgs::msg::Point>& turned) {
  turned.clear();
  for (const auto& point : footprint) {
    geometry_msgs::msg::Point& corner{turned.emplace_back()};
    corner.x = x + point.x * std::cos(theta) - point.y * std::sin(theta);
    corner.y = y + point.x * std::sin(theta) + point.y * std::cos(theta);
  }
}

}  // namespace nav2_costmap_2d
