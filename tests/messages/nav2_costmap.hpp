// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::messages::test {

namespace cost {
constexpr int free_space{0};
constexpr int inscribed{253};
constexpr int lethal{254};
constexpr int no_information{255};
}  // namespace cost

/// Behaviour that differs between versions of nav2_costmap_2d: bounds of the static layer in a rolling costmap, and
/// unknown cells with use_maximum.
enum class Nav2Version { jazzy, lyrical };

/// nav2_costmap_2d::Costmap2D.
struct CostCells {
  CostCells() = default;
  CostCells(int nx, int ny, double resolution, int default_cost);

  [[nodiscard]] bool world_to_map(Point2 world, int& mx, int& my) const;
  [[nodiscard]] Point2 map_to_world(int mx, int my) const;
  /// As worldToMapEnforceBounds().
  [[nodiscard]] CellIndex clamped(Point2 world) const;
  void update_origin(Point2 corner);
  [[nodiscard]] int& at(int mx, int my);
  [[nodiscard]] int at(int mx, int my) const;

  int nx{0};
  int ny{0};
  double resolution{0};
  Point2 origin{0, 0};
  int default_cost{0};
  std::vector<int> costs;
};

/// Area touched by an update, m.
struct Bounds {
  void touch(Point2 point);

  Point2 low{1e30, 1e30};
  Point2 high{-1e30, -1e30};
};

/// A rolling costmap of Nav2 after the sources of nav2_costmap_2d (layered_costmap.cpp, static_layer.cpp,
/// obstacle_layer.cpp, costmap_layer.cpp, inflation_layer.cpp), written again: no transforms but that of the scan, no
/// costmap filters, a round footprint. Messages are in its global frame.
class Nav2Costmap {
 public:
  /// `parameters`: ros__parameters of the costmap.
  Nav2Costmap(const YAML::Node& parameters, double robot_radius_m, Nav2Version version = Nav2Version::jazzy);

  void receive(const std::string& topic, const nav_msgs::OccupancyGrid& grid);
  void receive(const std::string& topic, const sensor_msgs::LaserScan& scan, const Pose2& world_from_scan);
  /// As LayeredCostmap::updateMap().
  void update(const Pose2& robot);

  [[nodiscard]] const CostCells& cells() const { return master_; }
  /// Unknown outside of it.
  [[nodiscard]] int cost_at(Point2 world) const;
  /// As StaticLayer::interpretValue().
  [[nodiscard]] int interpreted(std::int8_t value) const;

 private:
  struct Layer {
    YAML::Node parameters;
    std::string plugin;
    CostCells cells;
    std::vector<Point2> points;  ///< ends of the last scan's beams
    Point2 sensor{0, 0};
    bool has_data{false};
  };
  struct Area {
    int x0, y0, xn, yn;
  };

  template <class T>
  [[nodiscard]] T parameter(const char* name, T otherwise) const {
    return parameters_[name] ? parameters_[name].as<T>() : otherwise;
  }
  void add_bounds(Layer& layer, Bounds& bounds, const Pose2& robot) const;
  void add_obstacles(Layer& layer, Bounds& bounds, const Pose2& robot) const;
  void clear_ray(Layer& layer, Point2 end, double max_m, Bounds& bounds) const;
  void write_static(const Layer& layer, const Area& area, const Pose2& robot);
  void write_obstacles(Layer& layer, const Area& area, const Pose2& robot);
  void inflate(const Layer& layer, const Area& area);

  YAML::Node parameters_;
  double robot_radius_m_;
  Nav2Version version_;
  CostCells master_;
  std::vector<Layer> layers_;
};

}  // namespace stereogrid::messages::test
