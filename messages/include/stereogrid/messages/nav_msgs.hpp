// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::nav_msgs {

struct MapMetaData {
  STEREOGRID_MESSAGE("nav_msgs/msg/MapMetaData", map_load_time, resolution, width, height, origin);

  builtin_interfaces::Time map_load_time;
  float resolution{0};         ///< m
  std::uint32_t width{0};      ///< cells along x
  std::uint32_t height{0};     ///< cells along y
  geometry_msgs::Pose origin;  ///< outer corner of cell (0, 0)
};

struct OccupancyGrid {
  STEREOGRID_MESSAGE("nav_msgs/msg/OccupancyGrid", header, info, data);

  std_msgs::Header header;
  MapMetaData info;
  std::vector<std::int8_t> data;  ///< row by row, x fastest; stereogrid/occupancy_values.hpp
};

struct Odometry {
  STEREOGRID_MESSAGE("nav_msgs/msg/Odometry", header, child_frame_id, pose, twist);

  std_msgs::Header header;
  std::string child_frame_id;  ///< the frame of `twist`
  geometry_msgs::PoseWithCovariance pose;
  geometry_msgs::TwistWithCovariance twist;
};

}  // namespace stereogrid::messages::nav_msgs
