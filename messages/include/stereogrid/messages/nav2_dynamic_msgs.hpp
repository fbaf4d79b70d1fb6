// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::nav2_dynamic_msgs {

/// Layout since 2024, with covariances.
struct Obstacle {
  static constexpr std::string_view type_name{"nav2_dynamic_msgs/msg/Obstacle"};

  unique_identifier_msgs::UUID uuid;
  float score{0};
  geometry_msgs::Point position;                ///< m, centre
  geometry_msgs::Vector3 velocity;              ///< m/s
  geometry_msgs::Vector3 size;                  ///< m, along the axes of the header's frame
  std::array<double, 9> position_covariance{};  ///< m², row-major, axes of the header's frame
  std::array<double, 9> velocity_covariance{};  ///< m²/s²

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("uuid", self.uuid);
    visit("score", self.score);
    visit("position", self.position);
    visit("velocity", self.velocity);
    visit("size", self.size);
    visit("position_covariance", self.position_covariance);
    visit("velocity_covariance", self.velocity_covariance);
  }
};

struct ObstacleArray {
  static constexpr std::string_view type_name{"nav2_dynamic_msgs/msg/ObstacleArray"};

  std_msgs::Header header;
  std::vector<Obstacle> obstacles;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("obstacles", self.obstacles);
  }
};

}  // namespace stereogrid::messages::nav2_dynamic_msgs
