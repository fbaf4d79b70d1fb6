// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "fill/fill.hpp"

namespace stereogrid::messages {
namespace {

// Readers compute edges of cells with a float32 resolution: the corner must be the same number of such cells from the
// origin as in the grid.
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

// A cell of a packed grid, byte by byte.
constexpr std::size_t packed_bytes{7};
struct PackedField {
  const char* name;
  std::uint8_t type;
  std::uint32_t offset;
};
constexpr std::array<PackedField, 5> packed_fields{
    {{"occupancy_255ths", foxglove_msgs::PackedElementField::type_uint8, 0},
     {"moving_255ths", foxglove_msgs::PackedElementField::type_uint8, 1},
     {"velocity_x_cm_s", foxglove_msgs::PackedElementField::type_int16, 2},
     {"velocity_y_cm_s", foxglove_msgs::PackedElementField::type_int16, 4},
     {"age_ds", foxglove_msgs::PackedElementField::type_uint8, 6}}};
constexpr std::uint8_t never_observed{255};

int rounded(float value) {
  return static_cast<int>(value + (value < 0 ? -0.5f : 0.5f));
}

std::uint8_t packed_share(float share) {
  return static_cast<std::uint8_t>(rounded(255 * std::clamp(share, 0.0f, 1.0f)));
}

std::uint8_t packed_age(float age_s) {
  if (std::isinf(age_s)) return never_observed;
  return static_cast<std::uint8_t>(rounded(std::clamp(10 * age_s, 0.0f, float{never_observed - 1})));
}

void pack_velocity(float metres_per_s, std::uint8_t* bytes) {
  constexpr float most{std::numeric_limits<std::int16_t>::max()};
  const auto cm_s{static_cast<std::uint16_t>(rounded(std::clamp(100 * metres_per_s, -most, most)))};
  bytes[0] = static_cast<std::uint8_t>(cm_s & 0xff);
  bytes[1] = static_cast<std::uint8_t>(cm_s >> 8);
}

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

// Index (0, 0) is the corner of the largest x and y, column-major, with x and y descending: our order reversed.
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
    // unobserved cells are NaN
    const auto value = [](float cell, float age_s) {
      return std::isinf(age_s) ? std::numeric_limits<float>::quiet_NaN() : cell;
    };
    message.data[i].data.resize(grid.age_s.size());
    std::transform(layers[i].cells->begin(), layers[i].cells->end(), grid.age_s.begin(), message.data[i].data.rbegin(),
                   value);
  }
}

void fill(foxglove_msgs::Grid& message, const GridLayers& grid) {
  const GridGeometry& geometry{grid.geometry};
  message.pose.position = {geometry.x_min_m, geometry.y_min_m, 0};
  message.column_count = static_cast<std::uint32_t>(geometry.nx);
  message.cell_size = {geometry.cell_size_m, geometry.cell_size_m};
  message.cell_stride = packed_bytes;
  message.row_stride = message.column_count * message.cell_stride;
  message.fields.resize(packed_fields.size());
  for (std::size_t i{0}; i < packed_fields.size(); ++i) {
    message.fields[i].name = packed_fields[i].name;
    message.fields[i].offset = packed_fields[i].offset;
    message.fields[i].type = packed_fields[i].type;
  }
  const std::size_t cells{grid.age_s.size()};
  message.data.resize(packed_bytes * cells);
  for (std::size_t i{0}; i < cells; ++i) {
    std::uint8_t* const cell{message.data.data() + packed_bytes * i};
    cell[0] = packed_share(grid.occupancy.data()[i]);
    cell[1] = packed_share(grid.moving.data()[i]);
    pack_velocity(grid.velocity_x.data()[i], cell + 2);
    pack_velocity(grid.velocity_y.data()[i], cell + 4);
    cell[6] = packed_age(grid.age_s.data()[i]);
  }
}

}  // namespace stereogrid::messages
