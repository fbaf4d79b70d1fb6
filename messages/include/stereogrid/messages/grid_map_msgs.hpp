// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// As in ROS 2; in ROS 1 the header is part of the info.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::grid_map_msgs {

struct GridMapInfo {
  static constexpr std::string_view type_name{"grid_map_msgs/msg/GridMapInfo"};

  double resolution{0};      ///< m
  double length_x{0};        ///< m
  double length_y{0};        ///< m
  geometry_msgs::Pose pose;  ///< pose of the map's middle

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("resolution", self.resolution);
    visit("length_x", self.length_x);
    visit("length_y", self.length_y);
    visit("pose", self.pose);
  }
};

struct GridMap {
  static constexpr std::string_view type_name{"grid_map_msgs/msg/GridMap"};

  std_msgs::Header header;
  GridMapInfo info;
  std::vector<std::string> layers;
  std::vector<std::string> basic_layers;          ///< cells without a number in one of them have no data
  std::vector<std_msgs::Float32MultiArray> data;  ///< by layer; column-major from the corner of the largest x and y
  std::uint16_t outer_start_index{0};
  std::uint16_t inner_start_index{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("info", self.info);
    visit("layers", self.layers);
    visit("basic_layers", self.basic_layers);
    visit("data", self.data);
    visit("outer_start_index", self.outer_start_index);
    visit("inner_start_index", self.inner_start_index);
  }
};

}  // namespace stereogrid::messages::grid_map_msgs
