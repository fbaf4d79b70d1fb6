// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Copyright 2026 The stereogrid authors
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.
#include "grid_layer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include <geometry_msgs/msg/quaternion.hpp>
#include <geometry_msgs/msg/transform.hpp>
#include <nav2_costmap_2d/cost_values.hpp>
#include <nav2_costmap_2d/footprint.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>

namespace stereogrid_nav2 {
namespace {

using nav2_costmap_2d::FREE_SPACE;
using nav2_costmap_2d::LETHAL_OBSTACLE;
using nav2_costmap_2d::NO_INFORMATION;

constexpr int warning_period_ms{5000};
// Highest cost of a cell that is neither free nor an obstacle: below "inscribed".
constexpr int highest_between{252};

// Nav2's own node class differs between its versions; this base of it does not.
std::shared_ptr<rclcpp_lifecycle::LifecycleNode> locked(const std::shared_ptr<rclcpp_lifecycle::LifecycleNode>& node) {
  if (!node) throw std::runtime_error{"stereogrid_nav2::GridLayer: the costmap's node no longer exists"};
  return node;
}

}  // namespace

GridLayer::Point GridLayer::Source::at(double x_m, double y_m) const {
  return {corner[0] + axis[0] * x_m - axis[1] * y_m, corner[1] + axis[1] * x_m + axis[0] * y_m};
}

GridLayer::Point GridLayer::Source::centre(std::size_t cell) const {
  const auto resolution_m{static_cast<double>(grid->info.resolution)};
  return at((static_cast<double>(cell % grid->info.width) + 0.5) * resolution_m,
            (static_cast<double>(cell / grid->info.width) + 0.5) * resolution_m);
}

std::optional<std::size_t> GridLayer::Source::cell_at(Point point) const {
  const auto resolution_m{static_cast<double>(grid->info.resolution)};
  const Point away{point[0] - corner[0], point[1] - corner[1]};
  const double column{std::floor((axis[0] * away[0] + axis[1] * away[1]) / resolution_m)};
  const double row{std::floor((axis[0] * away[1] - axis[1] * away[0]) / resolution_m)};
  if (!(column >= 0 && column < grid->info.width && row >= 0 && row < grid->info.height)) return std::nullopt;
  return static_cast<std::size_t>(row) * grid->info.width + static_cast<std::size_t>(column);
}

template <class T>
void GridLayer::declare(const char* name, T usual, const char* description, double least, double most) {
  const auto node{locked(node_.lock())};
  const std::string full_name{name_ + "." + name};
  if (node->has_parameter(full_name)) return;  // configured before
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = description;
  if constexpr (std::is_same_v<T, int>) {
    descriptor.integer_range.resize(1);
    descriptor.integer_range.front().from_value = static_cast<std::int64_t>(least);
    descriptor.integer_range.front().to_value = static_cast<std::int64_t>(most);
    descriptor.integer_range.front().step = 1;
  } else if constexpr (std::is_same_v<T, double>) {
    descriptor.floating_point_range.resize(1);
    descriptor.floating_point_range.front().from_value = least;
    descriptor.floating_point_range.front().to_value = most;
  }
  descriptor.read_only = std::is_same_v<T, std::string>;
  node->declare_parameter(full_name, rclcpp::ParameterValue{usual}, descriptor);
}

rclcpp::Parameter GridLayer::parameter(const char* name) const {
  return locked(node_.lock())->get_parameter(name_ + "." + name);
}

void GridLayer::onInitialize() {
  declare("enabled", true, "Whether the layer writes.", 0, 1);
  declare("topic", std::string{"/stereo_grid/occupancy_grid"}, "Occupancy grid of the present.", 0, 0);
  declare("prediction_topic", std::string{}, "Grid whose obstacles are added. Empty: none.", 0, 0);
  declare("prediction_cost", int{LETHAL_OBSTACLE}, "Cost of the obstacles of prediction_topic.", 1, LETHAL_OBSTACLE);
  declare("free_threshold", 35, "Highest value of a free cell, %.", 0, 49);
  declare("lethal_threshold", 65, "Lowest value of an obstacle, %.", 50, 100);
  declare("combination_method", 1, "0: overwrites known cells of layers before. 1: maximum.", 0, 1);
  declare("footprint_clearing_enabled", true, "Whether this layer's cells below the robot are free.", 0, 1);
  declare("timeout", 1.0, "Age of a grid's stamp above which the costmap is not current, s.", 0.05, 60);
  read_parameters();
  default_value_ = NO_INFORMATION;
  current_ = false;
  matchSize();
  subscribe(sources_[0], "topic");
  subscribe(sources_[1], "prediction_topic");
}

void GridLayer::subscribe(Source& source, const char* topic_parameter) {
  source.topic = parameter(topic_parameter).as_string();
  if (source.topic.empty()) return;
  const rclcpp::QoS latched{rclcpp::QoS{1}.transient_local()};
  source.subscription =
      locked(node_.lock())->create_subscription<Grid>(source.topic, latched, [this, &source](const Grid& grid) {
        receive(source, grid);
      });
}

void GridLayer::read_parameters() {
  enabled_ = parameter("enabled").as_bool();
  prediction_cost_ = static_cast<unsigned char>(parameter("prediction_cost").as_int());
  free_threshold_ = static_cast<int>(parameter("free_threshold").as_int());
  lethal_threshold_ = static_cast<int>(parameter("lethal_threshold").as_int());
  overwrites_ = parameter("combination_method").as_int() == 0;
  clears_footprint_ = parameter("footprint_clearing_enabled").as_bool();
  timeout_s_ = parameter("timeout").as_double();
}

void GridLayer::receive(Source& source, const Grid& grid) {
  if (!(grid.info.resolution > 0) || grid.data.size() != std::size_t{grid.info.width} * grid.info.height) {
    RCLCPP_WARN_THROTTLE(logger_, *clock_, warning_period_ms, "%s: malformed grid on %s: %u x %u cells of %g m",
                         name_.c_str(), source.topic.c_str(), grid.info.width, grid.info.height,
                         static_cast<double>(grid.info.resolution));
    return;
  }
  const std::scoped_lock lock{mutex_};
  source.received = std::make_shared<const Grid>(grid);
}

bool GridLayer::locate(Source& source) const {
  const geometry_msgs::msg::Point& corner{source.grid->info.origin.position};
  const std::string frame{layered_costmap_->getGlobalFrameID()};
  source.corner = {0, 0};
  source.axis = {1, 0};
  if (source.grid->header.frame_id != frame) {
    try {
      const geometry_msgs::msg::Transform moved{tf_->lookupTransform(frame, source.grid->header.frame_id,
                                                                     rclcpp::Time{0},
                                                                     rclcpp::Duration{std::chrono::nanoseconds{0}})
                                                    .transform};
      const geometry_msgs::msg::Quaternion& turn{moved.rotation};
      const double yaw_rad{
          std::atan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y * turn.y + turn.z * turn.z))};
      source.corner = {moved.translation.x, moved.translation.y};
      source.axis = {std::cos(yaw_rad), std::sin(yaw_rad)};
    } catch (const tf2::TransformException& error) {
      RCLCPP_WARN_THROTTLE(logger_, *clock_, warning_period_ms, "%s: the place of the grid on %s is unknown: %s",
                           name_.c_str(), source.topic.c_str(), error.what());
      return false;
    }
  }
  source.corner = source.at(corner.x, corner.y);
  return true;
}

bool GridLayer::load(Source& source) {
  {
    const std::scoped_lock lock{mutex_};
    source.grid = source.received;
  }
  if (!source.subscription) return true;
  if (!source.grid) {
    RCLCPP_WARN_THROTTLE(logger_, *clock_, warning_period_ms, "%s: no grid on %s", name_.c_str(), source.topic.c_str());
    return false;
  }
  if (!locate(source)) {
    source.grid.reset();
    return false;
  }
  const nav_msgs::msg::MapMetaData& info{source.grid->info};
  for (const unsigned int columns : {0U, info.width}) {
    for (const unsigned int rows : {0U, info.height}) {
      const auto resolution_m{static_cast<double>(info.resolution)};
      const Point corner{source.at(columns * resolution_m, rows * resolution_m)};
      extend(corner[0], corner[1]);
    }
  }
  const double age_s{
      1e-9 * static_cast<double>(clock_->now().nanoseconds() - rclcpp::Time{source.grid->header.stamp}.nanoseconds())};
  if (std::abs(age_s) <= timeout_s_) return true;
  RCLCPP_WARN_THROTTLE(logger_, *clock_, warning_period_ms, "%s: the last grid on %s is %.1f s old (timeout %.1f s)",
                       name_.c_str(), source.topic.c_str(), age_s, timeout_s_);
  return false;
}

void GridLayer::updateBounds(double robot_x, double robot_y, double robot_yaw, double* min_x, double* min_y,
                             double* max_x, double* max_y) {
  read_parameters();
  if (layered_costmap_->isRolling()) {
    updateOrigin(robot_x - getSizeInMetersX() / 2, robot_y - getSizeInMetersY() / 2);
  }
  useExtraBounds(min_x, min_y, max_x, max_y);
  const Area before{area_};  // cells that the grid has left are reset
  area_ = Area{};
  bool is_current{true};
  if (enabled_) {
    for (Source& source : sources_) is_current = load(source) && is_current;
    nav2_costmap_2d::transformFootprint(robot_x, robot_y, robot_yaw, getFootprint(), footprint_);
    for (const auto& corner : footprint_) extend(corner.x, corner.y);
  }
  current_ = is_current;
  *min_x = std::min({*min_x, before.min_x, area_.min_x});
  *min_y = std::min({*min_y, before.min_y, area_.min_y});
  *max_x = std::max({*max_x, before.max_x, area_.max_x});
  *max_y = std::max({*max_y, before.max_y, area_.max_y});
}

unsigned char GridLayer::cost_of(std::int8_t value, bool is_prediction) const {
  if (value >= lethal_threshold_) return is_prediction ? prediction_cost_ : LETHAL_OBSTACLE;
  if (value < 0 || is_prediction) return NO_INFORMATION;
  if (value <= free_threshold_) return FREE_SPACE;
  const int above_free{value - free_threshold_};
  return static_cast<unsigned char>(highest_between * above_free / (lethal_threshold_ - free_threshold_));
}

void GridLayer::raise(unsigned int mx, unsigned int my, unsigned char cost) {
  unsigned char& own{costmap_[getIndex(mx, my)]};
  if (cost != NO_INFORMATION && (own == NO_INFORMATION || own < cost)) own = cost;
}

void GridLayer::write(const Source& source, bool is_prediction, int min_i, int min_j, int max_i, int max_j) {
  Point point{};
  for (int j{min_j}; j < max_j; ++j) {
    for (int i{min_i}; i < max_i; ++i) {
      const auto mx{static_cast<unsigned int>(i)};
      const auto my{static_cast<unsigned int>(j)};
      mapToWorld(mx, my, point[0], point[1]);
      if (const auto cell{source.cell_at(point)}) raise(mx, my, cost_of(source.grid->data[*cell], is_prediction));
    }
  }
  // Obstacles between the centres of the costmap's cells, where those are larger or turned.
  for (std::size_t cell{0}; cell < source.grid->data.size(); ++cell) {
    if (source.grid->data[cell] < lethal_threshold_) continue;
    unsigned int mx{0};
    unsigned int my{0};
    point = source.centre(cell);
    if (worldToMap(point[0], point[1], mx, my)) raise(mx, my, cost_of(source.grid->data[cell], is_prediction));
  }
}

void GridLayer::updateCosts(nav2_costmap_2d::Costmap2D& master, int min_i, int min_j, int max_i, int max_j) {
  if (!enabled_) return;
  resetMaps();
  for (const Source& source : sources_) {
    if (source.grid) write(source, &source == &sources_[1], min_i, min_j, max_i, max_j);
  }
  if (clears_footprint_) setConvexPolygonCost(footprint_, FREE_SPACE);
  if (overwrites_) {
    updateWithOverwrite(master, min_i, min_j, max_i, max_j);
  } else {
    updateWithMax(master, min_i, min_j, max_i, max_j);
  }
}

}  // namespace stereogrid_nav2

PLUGINLIB_EXPORT_CLASS(stereogrid_nav2::GridLayer, nav2_costmap_2d::Layer)
