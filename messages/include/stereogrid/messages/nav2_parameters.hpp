// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid::messages {

/// Message that Nav2's local costmap is made from.
enum class Nav2Source {
  grid,    ///< StaticLayer on an occupancy grid: free space, unknown cells, drops and predictions, without memory
  scan,    ///< ObstacleLayer on the scan: rays clear, and cells outside the field of view keep their last cost
  points,  ///< SpatioTemporalVoxelLayer on the obstacle points
  layer,   ///< stereogrid_nav2::GridLayer on occupancy grid and predictions (ros2/stereogrid_nav2)
};
constexpr std::array<std::string_view, 4> names_of(Nav2Source) {
  return {"grid", "scan", "points", "layer"};
}

struct Nav2Options {
  Nav2Source source{Nav2Source::grid};
  std::string node{"stereo_grid"};       ///< as in FrameMessagesOptions
  std::string world_frame{"odom"};       ///< global_frame of the costmap
  std::string robot_frame{"base_link"};  ///< robot_base_frame of the costmap
  std::string camera_frame{"stereo_left_optical"};
  bool has_predictions{false};  ///< the grid is `planning_grid`
};

/// YAML file with the parameters of Nav2's local costmap for the grids of a pipeline, published with
/// OccupancyScale::nav2. `rig`: Pipeline::rig(); `vehicle_grid`: Pipeline::vehicle_grid(). Sizes and ranges are those
/// of the grid and of its scan. Rules: nav2_costmap_2d of Humble to Lyrical (docs/ros2.md).
[[nodiscard]] STEREOGRID_EXPORT std::string nav2_local_costmap(const Rig& rig, const GridGeometry& vehicle_grid,
                                                               const Nav2Options& options = {});

}  // namespace stereogrid::messages
