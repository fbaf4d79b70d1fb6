// SPDX-License-Identifier: Apache-2.0
#include "nav2_costmap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace stereogrid::messages::test {
namespace {

double distance(Point2 a, Point2 b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

CostCells::CostCells(int nx_cells, int ny_cells, double resolution_m, int initial)
    : nx{nx_cells},
      ny{ny_cells},
      resolution{resolution_m},
      default_cost{initial},
      costs(static_cast<std::size_t>(nx_cells) * static_cast<std::size_t>(ny_cells), initial) {}

bool CostCells::world_to_map(Point2 world, int& mx, int& my) const {
  if (world.x < origin.x || world.y < origin.y) return false;
  mx = static_cast<int>((world.x - origin.x) / resolution);
  my = static_cast<int>((world.y - origin.y) / resolution);
  return mx < nx && my < ny;
}

Point2 CostCells::map_to_world(int mx, int my) const {
  return {origin.x + (mx + 0.5) * resolution, origin.y + (my + 0.5) * resolution};
}

CellIndex CostCells::clamped(Point2 world) const {
  const auto cell = [this](double from_m, int cells) {
    return std::clamp(static_cast<int>(std::clamp(from_m / resolution, -1.0, cells + 1.0)), 0, cells - 1);
  };
  return {cell(world.x - origin.x, nx), cell(world.y - origin.y, ny)};
}

void CostCells::update_origin(Point2 corner) {
  const int dx{static_cast<int>((corner.x - origin.x) / resolution)};
  const int dy{static_cast<int>((corner.y - origin.y) / resolution)};
  if (dx == 0 && dy == 0) return;
  CostCells moved{nx, ny, resolution, default_cost};
  moved.origin = {origin.x + dx * resolution, origin.y + dy * resolution};
  for (int my{std::max(0, -dy)}; my < std::min(ny, ny - dy); ++my) {
    for (int mx{std::max(0, -dx)}; mx < std::min(nx, nx - dx); ++mx) moved.at(mx, my) = at(mx + dx, my + dy);
  }
  *this = std::move(moved);
}

int& CostCells::at(int mx, int my) {
  return costs[static_cast<std::size_t>(my) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(mx)];
}

int CostCells::at(int mx, int my) const {
  return costs[static_cast<std::size_t>(my) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(mx)];
}

void Bounds::touch(Point2 point) {
  low = {std::min(low.x, point.x), std::min(low.y, point.y)};
  high = {std::max(high.x, point.x), std::max(high.y, point.y)};
}

Nav2Costmap::Nav2Costmap(const YAML::Node& parameters, double robot_radius_m, Nav2Version version)
    : parameters_{parameters}, robot_radius_m_{robot_radius_m}, version_{version} {
  EXPECT_TRUE(parameters["rolling_window"].as<bool>());
  const auto resolution{parameters["resolution"].as<double>()};
  const int initial{parameter("track_unknown_space", false) ? cost::no_information : cost::free_space};
  const auto cells = [&](const char* side) { return static_cast<int>(parameters[side].as<int>() / resolution); };
  master_ = {cells("width"), cells("height"), resolution, initial};
  for (const YAML::Node& name : parameters["plugins"]) {
    Layer& layer{layers_.emplace_back()};
    layer.parameters = parameters[name.as<std::string>()];
    layer.plugin = layer.parameters["plugin"].as<std::string>();
    if (layer.plugin == "nav2_costmap_2d::ObstacleLayer") layer.cells = master_;
  }
}

int Nav2Costmap::interpreted(std::int8_t cell) const {
  constexpr int inscribed_value{99};  // inscribed_obstacle_cost_value
  const int value{static_cast<std::uint8_t>(cell)};
  const int threshold{std::clamp(parameter("lethal_cost_threshold", 100), 0, 100)};
  if (value == parameter("unknown_cost_value", 255)) {
    return parameter("track_unknown_space", false) ? cost::no_information : cost::free_space;
  }
  if (value == inscribed_value) return cost::inscribed;
  if (value >= threshold) return cost::lethal;
  if (parameter("trinary_costmap", true)) return cost::free_space;
  return static_cast<int>(static_cast<double>(value) / threshold * cost::lethal);
}

void Nav2Costmap::receive(const std::string& topic, const nav_msgs::OccupancyGrid& grid) {
  EXPECT_EQ(grid.header.frame_id, parameters_["global_frame"].as<std::string>());
  std::array<int, 256> costs{};
  for (int value{-128}; value < 128; ++value) {
    costs[static_cast<std::uint8_t>(value)] = interpreted(static_cast<std::int8_t>(value));
  }
  for (Layer& layer : layers_) {
    if (layer.plugin != "nav2_costmap_2d::StaticLayer") continue;
    if (layer.parameters["map_topic"].as<std::string>() != topic) continue;
    layer.cells = {static_cast<int>(grid.info.width), static_cast<int>(grid.info.height),
                   static_cast<double>(grid.info.resolution), cost::no_information};
    layer.cells.origin = {grid.info.origin.position.x, grid.info.origin.position.y};
    std::ranges::transform(grid.data, layer.cells.costs.begin(),
                           [&](std::int8_t cell) { return costs[static_cast<std::uint8_t>(cell)]; });
    layer.has_data = true;
  }
}

void Nav2Costmap::receive(const std::string& topic, const sensor_msgs::LaserScan& scan, const Pose2& world_from_scan) {
  constexpr float epsilon{0.0001f};
  for (Layer& layer : layers_) {
    if (layer.plugin != "nav2_costmap_2d::ObstacleLayer") continue;
    const YAML::Node source{layer.parameters[layer.parameters["observation_sources"].as<std::string>()]};
    if (source["topic"].as<std::string>() != topic) continue;
    const bool inf_is_valid{source["inf_is_valid"].as<bool>()};
    layer.points.clear();
    for (std::size_t i{0}; i < scan.ranges.size(); ++i) {
      float range{scan.ranges[i]};
      if (inf_is_valid && !std::isfinite(range) && range > 0) range = scan.range_max - epsilon;
      if (!(range < scan.range_max && range >= scan.range_min)) continue;  // laser_geometry
      const float bearing_rad{scan.angle_min + static_cast<float>(i) * scan.angle_increment};
      layer.points.push_back(world_from_scan * Point2{static_cast<double>(range * std::cos(bearing_rad)),
                                                      static_cast<double>(range * std::sin(bearing_rad))});
    }
    layer.sensor = {world_from_scan.x_m, world_from_scan.y_m};
    layer.has_data = true;
  }
}

void Nav2Costmap::update(const Pose2& robot) {
  master_.update_origin(
      {robot.x_m - master_.nx * master_.resolution / 2, robot.y_m - master_.ny * master_.resolution / 2});
  Bounds bounds;
  for (Layer& layer : layers_) add_bounds(layer, bounds, robot);
  if (bounds.low.x > bounds.high.x) return;
  const CellIndex low{master_.clamped(bounds.low)};
  const CellIndex high{master_.clamped(bounds.high)};
  const Area area{low.ix, low.iy, std::min(master_.nx, high.ix + 1), std::min(master_.ny, high.iy + 1)};
  for (int y{area.y0}; y < area.yn; ++y) {
    for (int x{area.x0}; x < area.xn; ++x) master_.at(x, y) = master_.default_cost;
  }
  for (Layer& layer : layers_) {
    if (layer.plugin == "nav2_costmap_2d::StaticLayer") write_static(layer, area, robot);
    if (layer.plugin == "nav2_costmap_2d::ObstacleLayer") write_obstacles(layer, area, robot);
    if (layer.plugin == "nav2_costmap_2d::InflationLayer") inflate(layer, area);
  }
}

void Nav2Costmap::add_bounds(Layer& layer, Bounds& bounds, const Pose2& robot) const {
  if (layer.plugin == "nav2_costmap_2d::StaticLayer" && layer.has_data) {
    const bool is_whole_window{version_ == Nav2Version::lyrical};
    const double half_m{master_.nx * master_.resolution / 2};
    bounds.touch(is_whole_window ? Point2{robot.x_m - half_m, robot.y_m - half_m} : layer.cells.map_to_world(0, 0));
    bounds.touch(is_whole_window ? Point2{robot.x_m + half_m, robot.y_m + half_m}
                                 : layer.cells.map_to_world(layer.cells.nx, layer.cells.ny));
  } else if (layer.plugin == "nav2_costmap_2d::ObstacleLayer") {
    add_obstacles(layer, bounds, robot);
  } else if (layer.plugin == "nav2_costmap_2d::InflationLayer" && bounds.low.x <= bounds.high.x) {
    const auto radius_m{layer.parameters["inflation_radius"].as<double>()};
    bounds.touch({bounds.low.x - radius_m, bounds.low.y - radius_m});
    bounds.touch({bounds.high.x + radius_m, bounds.high.y + radius_m});
  }
}

void Nav2Costmap::add_obstacles(Layer& layer, Bounds& bounds, const Pose2& robot) const {
  layer.cells.update_origin({robot.x_m - layer.cells.nx * layer.cells.resolution / 2,
                             robot.y_m - layer.cells.ny * layer.cells.resolution / 2});
  const YAML::Node source{layer.parameters[layer.parameters["observation_sources"].as<std::string>()]};
  if (source["clearing"].as<bool>()) {
    const auto max_m{source["raytrace_max_range"].as<double>()};
    for (const Point2 point : layer.points) clear_ray(layer, point, max_m, bounds);
  }
  const bool is_marking{source["marking"].as<bool>()};
  const auto least_m{source["obstacle_min_range"].as<double>()};
  const auto most_m{source["obstacle_max_range"].as<double>()};
  for (const Point2 point : layer.points) {
    const double range_m{distance(point, layer.sensor)};
    const bool is_within{range_m < most_m && range_m >= least_m};
    int mx{0};
    int my{0};
    if (!is_marking || !is_within || !layer.cells.world_to_map(point, mx, my)) continue;
    layer.cells.at(mx, my) = cost::lethal;
    bounds.touch(point);
  }
  bounds.touch({robot.x_m - robot_radius_m_, robot.y_m - robot_radius_m_});
  bounds.touch({robot.x_m + robot_radius_m_, robot.y_m + robot_radius_m_});
}

// Bresenham's line from the sensor towards the end, raytrace_max_range (`max_m`) at most.
void Nav2Costmap::clear_ray(Layer& layer, Point2 end, double max_m, Bounds& bounds) const {
  int x0{0};
  int y0{0};
  int x1{0};
  int y1{0};
  if (!layer.cells.world_to_map(layer.sensor, x0, y0) || !layer.cells.world_to_map(end, x1, y1)) return;
  const int steps{std::max(std::abs(x1 - x0), std::abs(y1 - y0))};
  const double length{std::hypot(x1 - x0, y1 - y0)};
  const double scale{length == 0 ? 1 : std::min(1.0, std::ceil(max_m / layer.cells.resolution) / length)};
  for (int i{0}; i <= static_cast<int>(scale * steps); ++i) {
    const double share{steps == 0 ? 0 : static_cast<double>(i) / steps};
    layer.cells.at(x0 + static_cast<int>(std::lround(share * (x1 - x0))),
                   y0 + static_cast<int>(std::lround(share * (y1 - y0)))) = cost::free_space;
  }
  bounds.touch(layer.sensor);
  bounds.touch(end);
}

void Nav2Costmap::write_static(const Layer& layer, const Area& area, const Pose2& robot) {
  if (!layer.has_data) return;
  const bool uses_maximum{parameter("use_maximum", false)};  // read from the costmap, not from the layer
  const YAML::Node clearing{layer.parameters["footprint_clearing_enabled"]};
  const bool clears_footprint{clearing && clearing.as<bool>()};
  for (int y{area.y0}; y < area.yn; ++y) {
    for (int x{area.x0}; x < area.xn; ++x) {
      const Point2 world{master_.map_to_world(x, y)};
      int mx{0};
      int my{0};
      if (!layer.cells.world_to_map(world, mx, my)) continue;
      const bool is_own{clears_footprint && distance(world, {robot.x_m, robot.y_m}) < robot_radius_m_};
      const int cost{is_own ? cost::free_space : layer.cells.at(mx, my)};
      int& to{master_.at(x, y)};
      if (!uses_maximum) {
        to = cost;
      } else if (version_ == Nav2Version::jazzy) {
        to = std::max(to, cost);
      } else if (cost != cost::no_information && (to == cost::no_information || cost > to)) {
        to = cost;
      }
    }
  }
}

// CostmapLayer::updateWithMax().
void Nav2Costmap::write_obstacles(Layer& layer, const Area& area, const Pose2& robot) {
  EXPECT_EQ(layer.parameters["combination_method"].as<int>(), 1);
  for (int y{area.y0}; y < area.yn; ++y) {
    for (int x{area.x0}; x < area.xn; ++x) {
      int& own{layer.cells.at(x, y)};
      if (distance(master_.map_to_world(x, y), {robot.x_m, robot.y_m}) < robot_radius_m_) own = cost::free_space;
      if (own == cost::no_information) continue;
      int& to{master_.at(x, y)};
      if (to == cost::no_information || to < own) to = own;
    }
  }
}

void Nav2Costmap::inflate(const Layer& layer, const Area& area) {
  const auto radius_m{layer.parameters["inflation_radius"].as<double>()};
  const auto scaling{layer.parameters["cost_scaling_factor"].as<double>()};
  const int reach{static_cast<int>(std::ceil(radius_m / master_.resolution))};
  const CostCells before{master_};
  for (int iy{std::max(0, area.y0 - reach)}; iy < std::min(master_.ny, area.yn + reach); ++iy) {
    for (int ix{std::max(0, area.x0 - reach)}; ix < std::min(master_.nx, area.xn + reach); ++ix) {
      if (before.at(ix, iy) != cost::lethal) continue;
      for (int y{std::max(area.y0, iy - reach)}; y < std::min(area.yn, iy + reach + 1); ++y) {
        for (int x{std::max(area.x0, ix - reach)}; x < std::min(area.xn, ix + reach + 1); ++x) {
          const double away_m{std::hypot(x - ix, y - iy) * master_.resolution};
          if (away_m > reach * master_.resolution || (x == ix && y == iy)) continue;
          const double decay{std::exp(-scaling * (away_m - robot_radius_m_))};
          const int cost{away_m <= robot_radius_m_ ? cost::inscribed : static_cast<int>((cost::inscribed - 1) * decay)};
          int& to{master_.at(x, y)};
          if (to == cost::no_information) {
            if (cost >= cost::inscribed) to = cost;  // inflate_unknown: false
          } else {
            to = std::max(to, cost);
          }
        }
      }
    }
  }
}

int Nav2Costmap::cost_at(Point2 world) const {
  int mx{0};
  int my{0};
  return master_.world_to_map(world, mx, my) ? master_.at(mx, my) : cost::no_information;
}

}  // namespace stereogrid::messages::test
