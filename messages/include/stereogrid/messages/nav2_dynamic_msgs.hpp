// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::nav2_dynamic_msgs {

/// Layout since 2024, with covariances.
struct Obstacle {
  STEREOGRID_MESSAGE("nav2_dynamic_msgs/msg/Obstacle", uuid, score, position, velocity, size, position_covariance,
                     velocity_covariance);

  unique_identifier_msgs::UUID uuid;
  float score{0};
  geometry_msgs::Point position;                ///< m, centre
  geometry_msgs::Vector3 velocity;              ///< m/s
  geometry_msgs::Vector3 size;                  ///< m, along the axes of the header's frame
  std::array<double, 9> position_covariance{};  ///< m², row-major, axes of the header's frame
  std::array<double, 9> velocity_covariance{};  ///< m²/s²
};

struct ObstacleArray {
  STEREOGRID_MESSAGE("nav2_dynamic_msgs/msg/ObstacleArray", header, obstacles);

  std_msgs::Header header;
  std::vector<Obstacle> obstacles;
};

}  // namespace stereogrid::messages::nav2_dynamic_msgs
