// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// As in ROS 2; in ROS 1 the header is part of the info.
#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::grid_map_msgs {

struct GridMapInfo {
  STEREOGRID_MESSAGE("grid_map_msgs/msg/GridMapInfo", resolution, length_x, length_y, pose);

  double resolution{0};      ///< m
  double length_x{0};        ///< m
  double length_y{0};        ///< m
  geometry_msgs::Pose pose;  ///< pose of the map's middle
};

struct GridMap {
  STEREOGRID_MESSAGE("grid_map_msgs/msg/GridMap", header, info, layers, basic_layers, data, outer_start_index,
                     inner_start_index);

  std_msgs::Header header;
  GridMapInfo info;
  std::vector<std::string> layers;
  std::vector<std::string> basic_layers;          ///< cells without a number in one of them have no data
  std::vector<std_msgs::Float32MultiArray> data;  ///< by layer; column-major from the corner of the largest x and y
  std::uint16_t outer_start_index{0};
  std::uint16_t inner_start_index{0};
};

}  // namespace stereogrid::messages::grid_map_msgs
