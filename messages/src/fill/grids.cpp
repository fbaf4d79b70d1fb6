// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fill/fill.hpp"

namespace stereogrid::messages {
namespace {

// Readers compute edges of cells with the resolution that they find, which is float32: the corner has to be as many of
// those cells away from the origin as it is in the grid.
double corner(double min_m, double cell_size_m, float resolution) {
  const double cells{min_m / cell_size_m};
  const double whole{std::round(cells)};
  const bool is_snapped{std::abs(cells - whole) < 1e-6};
  return (is_snapped ? whole : cells) * static_cast<double>(resolution);
}

struct Layer {
  const char* name;
  const Image<float>* cells;
};

void lay_out(std_msgs::MultiArrayLayout& layout, int rows, int columns) {
  layout.dim.resize(2);
  layout.dim[0].label = "column_index";
  layout.dim[0].size = static_cast<std::uint32_t>(columns);
  layout.dim[0].stride = static_cast<std::uint32_t>(rows) * static_cast<std::uint32_t>(columns);
  layout.dim[1].label = "row_index";
  layout.dim[1].size = static_cast<std::uint32_t>(rows);
  layout.dim[1].stride = static_cast<std::uint32_t>(rows);
}

}  // namespace

void fill(nav_msgs::OccupancyGrid& message, const GridGeometry& geometry, const Image<float>& occupancy,
          OccupancyScale scale) {
  nav_msgs::MapMetaData& info{message.info};
  info.map_load_time = message.header.stamp;
  info.resolution = static_cast<float>(geometry.cell_size_m);
  info.width = static_cast<std::uint32_t>(occupancy.width());
  info.height = static_cast<std::uint32_t>(occupancy.height());
  info.origin.position = {corner(geometry.x_min_m, geometry.cell_size_m, info.resolution),
                          corner(geometry.y_min_m, geometry.cell_size_m, info.resolution), 0};
  message.data.resize(occupancy.size());
  std::ranges::transform(occupancy, message.data.begin(), [&](float p) { return occupancy_value(p, scale); });
}

// Index (0, 0) is the corner of the largest x and y; rows go down x, columns down y, and one column comes after the
// other: our order, backwards.
void fill(grid_map_msgs::GridMap& message, const GridLayers& grid) {
  const GridGeometry& geometry{grid.geometry};
  message.info.resolution = geometry.cell_size_m;
  message.info.length_x = geometry.nx * geometry.cell_size_m;
  message.info.length_y = geometry.ny * geometry.cell_size_m;
  message.info.pose.position = {geometry.x_min_m + message.info.length_x / 2,
                                geometry.y_min_m + message.info.length_y / 2, 0};
  const std::array<Layer, 5> layers{{{"occupancy", &grid.occupancy},
                                     {"velocity_x", &grid.velocity_x},
                                     {"velocity_y", &grid.velocity_y},
                                     {"moving", &grid.moving},
                                     {"age", &grid.age_s}}};
  message.layers.resize(layers.size());
  message.data.resize(layers.size());
  message.basic_layers.resize(1);
  message.basic_layers.front() = "occupancy";
  for (std::size_t i{0}; i < layers.size(); ++i) {
    message.layers[i] = layers[i].name;
    lay_out(message.data[i].layout, geometry.nx, geometry.ny);
    // of cells that were never observed nothing is known
    const auto value = [](float cell, float age_s) {
      return std::isinf(age_s) ? std::numeric_limits<float>::quiet_NaN() : cell;
    };
    message.data[i].data.resize(grid.age_s.size());
    std::transform(layers[i].cells->begin(), layers[i].cells->end(), grid.age_s.begin(), message.data[i].data.rbegin(),
                   value);
  }
}

}  // namespace stereogrid::messages
