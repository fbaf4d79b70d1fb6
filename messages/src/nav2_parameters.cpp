// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/nav2_parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "stereogrid/image.hpp"
#include "stereogrid/messages/frame_messages.hpp"

namespace stereogrid::messages {
namespace {

// Heights of points that count as obstacles, m over the vehicle frame. The scan lies at 0, give or take the pitch of
// the vehicle.
constexpr double lowest_m{-0.5};
constexpr double highest_m{2};
// Seconds that a voxel of SpatioTemporalVoxelLayer lasts without being seen again.
constexpr double voxel_decay_s{1};

// At most six decimals, at least one: Nav2 rejects "1" where it declares a double.
std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6f", value);
  std::string digits{text.data()};
  while (digits.ends_with("00") || (digits.ends_with('0') && digits[digits.size() - 2] != '.')) digits.pop_back();
  return digits;
}

std::string line(int indent, const std::string& key, const std::string& value) {
  return std::string(static_cast<std::size_t>(indent), ' ') + key + ": " + value + "\n";
}

double scan_range_max_m(const Rig& rig, const GridGeometry& grid) {
  const Image<float> unknown{grid.nx, grid.ny, 0.5f};
  sensor_msgs::LaserScan scan;
  fill(scan, {&rig, 1}, grid, unknown.view());
  return static_cast<double>(scan.range_max);
}

double farthest_corner_m(const GridGeometry& grid) {
  const double x_m{grid.x_min_m + grid.nx * grid.cell_size_m};
  const double y_m{std::max(-grid.y_min_m, grid.y_min_m + grid.ny * grid.cell_size_m)};
  return std::hypot(x_m, y_m);
}

std::string grid_layer(const Nav2Options& options) {
  const std::string topic{options.has_predictions ? "planning_grid" : "occupancy_grid"};
  return "      stereo_grid:\n" + line(8, "plugin", "nav2_costmap_2d::StaticLayer") +
         line(8, "map_topic", "/" + options.node + "/" + topic) + line(8, "map_subscribe_transient_local", "true") +
         line(8, "subscribe_to_updates", "false") + line(8, "footprint_clearing_enabled", "true");
}

std::string observation(const std::string& topic, const std::string& type, double near_m, double far_m) {
  return line(10, "topic", topic) + line(10, "data_type", type) + line(10, "min_obstacle_height", number(near_m)) +
         line(10, "max_obstacle_height", number(far_m));
}

std::string scan_layer(const Rig& rig, const GridGeometry& grid, const Nav2Options& options) {
  const double range_max_m{scan_range_max_m(rig, grid)};
  return "      stereo_grid:\n" + line(8, "plugin", "nav2_costmap_2d::ObstacleLayer") +
         line(8, "combination_method", "1") + line(8, "min_obstacle_height", number(lowest_m)) +
         line(8, "max_obstacle_height", number(highest_m)) + line(8, "observation_sources", "scan") +
         "        scan:\n" + observation("/" + options.node + "/scan", "LaserScan", lowest_m, highest_m) +
         line(10, "marking", "true") + line(10, "clearing", "true") +
         "          # Beams that met nothing (+inf) clear as far as range_max of the scan, " + number(range_max_m) +
         " m here.\n          # Their ends must lie beyond obstacle_max_range, or they are marked as obstacles.\n" +
         line(10, "inf_is_valid", "true") +
         line(10, "obstacle_max_range", number(std::max(range_max_m - grid.cell_size_m, grid.cell_size_m / 2))) +
         line(10, "obstacle_min_range", "0.0") + line(10, "raytrace_max_range", number(range_max_m)) +
         line(10, "raytrace_min_range", "0.0");
}

std::string points_layer(const Rig& rig, const GridGeometry& grid, const Nav2Options& options) {
  const double far_m{farthest_corner_m(grid)};
  // about the optical axis: the narrower side, so that cells outside of the image are not cleared
  const HorizontalView view{horizontal_view(rig)};
  const double across_rad{2 * std::min(view.left_rad, -view.right_rad)};
  const double upright_rad{2 * std::atan((std::min(rig.cy_px, rig.height_px - 1 - rig.cy_px) + 0.5) / rig.focal_px)};
  const std::string frame{line(10, "sensor_frame", options.camera_frame)};
  const std::string topic{"/" + options.node + "/obstacle_points"};
  return "      stereo_grid:\n" + line(8, "plugin", "spatio_temporal_voxel_layer/SpatioTemporalVoxelLayer") +
         line(8, "enabled", "true") + line(8, "voxel_decay", number(voxel_decay_s)) +
         line(8, "decay_model", "0  # linear") + line(8, "voxel_size", number(grid.cell_size_m)) +
         line(8, "track_unknown_space", "true") + line(8, "mark_threshold", "0") +
         line(8, "update_footprint_enabled", "true") + line(8, "combination_method", "1") +
         line(8, "publish_voxel_map", "false") + line(8, "mapping_mode", "false") +
         line(8, "observation_sources", "mark clear") + "        mark:\n" +
         observation(topic, "PointCloud2", 0, highest_m) + frame + line(10, "marking", "true") +
         line(10, "clearing", "false") + line(10, "obstacle_range", number(far_m)) +
         line(10, "clear_after_reading", "true") + "        clear:\n" +
         observation(topic, "PointCloud2", 0, highest_m) + frame + line(10, "marking", "false") +
         line(10, "clearing", "true") + line(10, "min_z", number(rig.baseline_m)) + line(10, "max_z", number(far_m)) +
         line(10, "horizontal_fov_angle", number(across_rad)) + line(10, "vertical_fov_angle", number(upright_rad)) +
         line(10, "decay_acceleration", "5.0") + line(10, "model_type", "0  # depth camera: z of sensor_frame ahead") +
         line(10, "clear_after_reading", "true");
}

std::string own_layer(const Nav2Options& options) {
  std::string text{"      stereo_grid:\n" + line(8, "plugin", "stereogrid_nav2::GridLayer") +
                   line(8, "topic", "/" + options.node + "/occupancy_grid")};
  if (options.has_predictions) text += line(8, "prediction_topic", "/" + options.node + "/planning_grid");
  return text + "        # Values of the scale nav2; those of percent are 35 and 65.\n" +
         line(8, "free_threshold", "0") + line(8, "lethal_threshold", "100") + line(8, "timeout", "1.0");
}

}  // namespace

std::string nav2_local_costmap(const Rig& rig, const GridGeometry& grid, const Nav2Options& options) {
  const std::string side_m{std::to_string(static_cast<int>(std::ceil(2 * farthest_corner_m(grid))))};
  std::string text{"# Nav2's local costmap for stereogrid --ros2 --value-scale nav2"};
  if (options.has_predictions) text += " --predict …";
  text += "\nlocal_costmap:\n  local_costmap:\n    ros__parameters:\n";
  text += line(6, "global_frame", options.world_frame) + line(6, "robot_base_frame", options.robot_frame) +
          line(6, "rolling_window", "true") + "      # m: covers the grid in every heading\n" +
          line(6, "width", side_m) + line(6, "height", side_m) +
          "      # m: that of the grid, so that cells of both coincide\n" +
          line(6, "resolution", number(grid.cell_size_m)) + line(6, "update_frequency", "10.0") +
          line(6, "publish_frequency", "5.0") + line(6, "transform_tolerance", "0.3") +
          "      # Unknown cells stay unknown. false: they are free.\n" + line(6, "track_unknown_space", "true");
  if (options.source == Nav2Source::grid) {
    text += "      # Costs between free and lethal. true: all below the threshold is free.\n" +
            line(6, "trinary_costmap", "false") + line(6, "lethal_cost_threshold", "100") +
            line(6, "unknown_cost_value", "255");
  }
  text += line(6, "plugins", "[stereo_grid, inflation]");
  if (options.source == Nav2Source::grid) text += grid_layer(options);
  if (options.source == Nav2Source::scan) text += scan_layer(rig, grid, options);
  if (options.source == Nav2Source::points) text += points_layer(rig, grid, options);
  if (options.source == Nav2Source::layer) text += own_layer(options);
  return text + "      inflation:\n" + line(8, "plugin", "nav2_costmap_2d::InflationLayer") +
         "        # Those of the robot.\n" + line(8, "inflation_radius", "0.6") + line(8, "cost_scaling_factor", "3.0");
}

}  // namespace stereogrid::messages
