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
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <nav2_costmap_2d/costmap_layer.hpp>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <rclcpp/rclcpp.hpp>

namespace stereogrid_nav2 {

/// Costs of `occupancy_grid` (free space, obstacles, drops) and of the obstacles of a grid of predictions, such as
/// `planning_grid`. Unknown cells keep the cost of other layers. Parameters: README.md.
class GridLayer : public nav2_costmap_2d::CostmapLayer {
 public:
  void updateBounds(double robot_x, double robot_y, double robot_yaw, double* min_x, double* min_y, double* max_x,
                    double* max_y) override;
  void updateCosts(nav2_costmap_2d::Costmap2D& master, int min_i, int min_j, int max_i, int max_j) override;
  /// Not current until the next update.
  void reset() override { current_ = false; }
  /// False: the layer has no memory that could be cleared.
  bool isClearable() override { return false; }

 protected:
  /// Throws rclcpp's exceptions where parameters are out of range.
  void onInitialize() override;

 private:
  using Grid = nav_msgs::msg::OccupancyGrid;
  using Point = std::array<double, 2>;

  struct Source {
    std::string topic;
    rclcpp::Subscription<Grid>::SharedPtr subscription;  ///< empty: not used
    std::shared_ptr<const Grid> received;                ///< guarded by mutex_
    std::shared_ptr<const Grid> grid;                    ///< grid of this update; empty: none
    Point corner{0, 0};                                  ///< the grid's corner in the costmap's frame, m
    Point axis{1, 0};                                    ///< direction of its rows there

    /// Point of the costmap's frame, from a point relative to the grid's corner.
    [[nodiscard]] Point at(double x_m, double y_m) const;
    [[nodiscard]] Point centre(std::size_t cell) const;
    /// Index of the cell at a point of the costmap's frame.
    [[nodiscard]] std::optional<std::size_t> cell_at(Point point) const;
  };
  /// Area of the last update, m.
  struct Area {
    double min_x{std::numeric_limits<double>::max()};
    double min_y{std::numeric_limits<double>::max()};
    double max_x{std::numeric_limits<double>::lowest()};
    double max_y{std::numeric_limits<double>::lowest()};
  };

  template <class T>
  void declare(const char* name, T usual, const char* description, double least, double most);
  [[nodiscard]] rclcpp::Parameter parameter(const char* name) const;
  void subscribe(Source& source, const char* topic_parameter);
  void read_parameters();
  void receive(Source& source, const Grid& grid);
  /// Returns whether the place of the source's grid is known.
  [[nodiscard]] bool locate(Source& source) const;
  /// Takes the newest grid. Returns whether it is recent and its place is known.
  bool load(Source& source);
  void extend(double x, double y) { touch(x, y, &area_.min_x, &area_.min_y, &area_.max_x, &area_.max_y); }
  [[nodiscard]] unsigned char cost_of(std::int8_t value, bool is_prediction) const;
  void raise(unsigned int mx, unsigned int my, unsigned char cost);
  void write(const Source& source, bool is_prediction, int min_i, int min_j, int max_i, int max_j);

  std::mutex mutex_;
  std::array<Source, 2> sources_;  ///< the present, predictions
  Area area_;
  std::vector<geometry_msgs::msg::Point> footprint_;  ///< the robot's, in the costmap's frame

  // parameters
  int free_threshold_{0};
  int lethal_threshold_{0};
  unsigned char prediction_cost_{0};
  bool overwrites_{false};
  bool clears_footprint_{false};
  double timeout_s_{0};
};

}  // namespace stereogrid_nav2
