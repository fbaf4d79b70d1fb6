// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::nav_msgs {

struct MapMetaData {
  static constexpr std::string_view type_name{"nav_msgs/msg/MapMetaData"};

  builtin_interfaces::Time map_load_time;
  float resolution{0};         ///< m
  std::uint32_t width{0};      ///< cells along x
  std::uint32_t height{0};     ///< cells along y
  geometry_msgs::Pose origin;  ///< outer corner of cell (0, 0)

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("map_load_time", self.map_load_time);
    visit("resolution", self.resolution);
    visit("width", self.width);
    visit("height", self.height);
    visit("origin", self.origin);
  }
};

struct OccupancyGrid {
  static constexpr std::string_view type_name{"nav_msgs/msg/OccupancyGrid"};

  std_msgs::Header header;
  MapMetaData info;
  std::vector<std::int8_t> data;  ///< row by row, x fastest; stereogrid/occupancy_values.hpp

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("info", self.info);
    visit("data", self.data);
  }
};

struct Odometry {
  static constexpr std::string_view type_name{"nav_msgs/msg/Odometry"};

  std_msgs::Header header;
  std::string child_frame_id;  ///< the frame of `twist`
  geometry_msgs::PoseWithCovariance pose;
  geometry_msgs::TwistWithCovariance twist;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("child_frame_id", self.child_frame_id);
    visit("pose", self.pose);
    visit("twist", self.twist);
  }
};

}  // namespace stereogrid::messages::nav_msgs
