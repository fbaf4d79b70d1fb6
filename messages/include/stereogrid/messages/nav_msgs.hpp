// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Types of the packages nav_msgs, grid_map_msgs and nav2_dynamic_msgs.
#include <array>
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

/// Cells of one kind, such as occupied ones.
struct GridCells {
  STEREOGRID_MESSAGE("nav_msgs/msg/GridCells", header, cell_width, cell_height, cells);

  std_msgs::Header header;
  float cell_width{0};                      ///< m, along x
  float cell_height{0};                     ///< m, along y
  std::vector<geometry_msgs::Point> cells;  ///< centres
};

struct Odometry {
  STEREOGRID_MESSAGE("nav_msgs/msg/Odometry", header, child_frame_id, pose, twist);

  std_msgs::Header header;
  std::string child_frame_id;  ///< the frame of `twist`
  geometry_msgs::PoseWithCovariance pose;
  geometry_msgs::TwistWithCovariance twist;
};

}  // namespace stereogrid::messages::nav_msgs

// As in ROS 2; in ROS 1 the header is part of the info.
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
