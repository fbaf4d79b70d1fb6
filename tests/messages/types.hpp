// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include "stereogrid/messages/foxglove_msgs.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"
#include "stereogrid/messages/vision_msgs.hpp"
#include "stereogrid/messages/visualization_msgs.hpp"

namespace stereogrid::messages::test {

/// Published types; all others are parts of them.
using Types = std::tuple<nav_msgs::OccupancyGrid, nav_msgs::Odometry, grid_map_msgs::GridMap, foxglove_msgs::Grid,
                         nav2_dynamic_msgs::ObstacleArray, vision_msgs::Detection3DArray,
                         visualization_msgs::MarkerArray, stereo_msgs::DisparityImage, sensor_msgs::PointCloud2,
                         sensor_msgs::CompressedImage, sensor_msgs::LaserScan, sensor_msgs::Image,
                         sensor_msgs::CameraInfo, tf2_msgs::TFMessage, diagnostic_msgs::DiagnosticArray>;

/// Calls `work` with a message of each type.
template <class Work>
void for_each_type(Work&& work) {
  std::apply([&](const auto&... message) { (work(message), ...); }, Types{});
}

}  // namespace stereogrid::messages::test
