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

void set_info(nav_msgs::OccupancyGrid& message, const GridGeometry& geometry) {
  nav_msgs::MapMetaData& info{message.info};
  info.map_load_time = message.header.stamp;
  info.resolution = static_cast<float>(geometry.cell_size_m);
  info.width = static_cast<std::uint32_t>(geometry.nx);
  info.height = static_cast<std::uint32_t>(geometry.ny);
  info.origin.position = {corner(geometry.x_min_m, geometry.cell_size_m, info.resolution),
                          corner(geometry.y_min_m, geometry.cell_size_m, info.resolution), 0};
  message.data.resize(static_cast<std::size_t>(geometry.nx) * static_cast<std::size_t>(geometry.ny));
}

struct Layer {
  const char* name;
  const Image<float>* cells;
};

constexpr float not_a_number{std::numeric_limits<float>::quiet_NaN()};

// Calls `set(i, value)` for cell i of the world's grid, in its order, with the value of the vehicle's cell at its
// centre; `outside` beyond the vehicle's grid.
template <class T, class Set>
void for_world_cells(const FrameResult& result, const Image<T>& vehicle_layer, T outside, Set&& set) {
  const GridGeometry& grid{result.world.geometry};
  const Pose2 vehicle_from_world{inverse(result.world_from_vehicle)};
  const Point2 origin{vehicle_from_world * grid.centre(0, 0)};
  const Point2 along{vehicle_from_world * grid.centre(1, 0)};  // y: left of it
  const Point2 step{along.x - origin.x, along.y - origin.y};
  std::size_t i{0};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 place{origin.x + ix * step.x - iy * step.y, origin.y + ix * step.y + iy * step.x};
      const auto cell{result.vehicle.geometry.cell_at(place)};
      set(i++, cell ? vehicle_layer(cell->ix, cell->iy) : outside);
    }
  }
}

// A cell of a packed grid, byte by byte. The last three fields are left out of results without elevation.
constexpr std::size_t elevation_offset{7};
constexpr std::size_t witness_offset{9};
constexpr std::size_t terrain_offset{10};
struct PackedField {
  const char* name;
  std::uint8_t type;
  std::uint32_t offset;
};
constexpr std::array<PackedField, 8> packed_fields{
    {{"occupancy_255ths", foxglove_msgs::PackedElementField::type_uint8, 0},
     {"moving_255ths", foxglove_msgs::PackedElementField::type_uint8, 1},
     {"velocity_x_cm_s", foxglove_msgs::PackedElementField::type_int16, 2},
     {"velocity_y_cm_s", foxglove_msgs::PackedElementField::type_int16, 4},
     {"age_ds", foxglove_msgs::PackedElementField::type_uint8, 6},
     {"elevation_cm", foxglove_msgs::PackedElementField::type_int16, elevation_offset},
     {"witness", foxglove_msgs::PackedElementField::type_uint8, witness_offset},
     {"terrain", foxglove_msgs::PackedElementField::type_uint8, terrain_offset}}};
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

// Hundredths of a value; NaN: −32768.
void pack_hundredths(float value, std::uint8_t* bytes) {
  constexpr float most{std::numeric_limits<std::int16_t>::max()};
  const int number{std::isnan(value) ? std::numeric_limits<std::int16_t>::min()
                                     : rounded(std::clamp(100 * value, -most, most))};
  bytes[0] = static_cast<std::uint8_t>(number & 0xff);
  bytes[1] = static_cast<std::uint8_t>(number >> 8 & 0xff);
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
  set_info(message, geometry);
  std::ranges::transform(occupancy, message.data.begin(), [&](float p) { return occupancy_value(p, scale); });
}

void fill_highest(nav_msgs::OccupancyGrid& message, const FrameResult& result, OccupancyScale scale) {
  set_info(message, result.world.geometry);
  for (std::size_t i{0}; i < message.data.size(); ++i) {
    float highest{result.world.occupancy.data()[i]};
    for (const Prediction& prediction : result.predictions) {
      const float later{prediction.world_occupancy.data()[i]};
      if (is_known(later)) highest = std::max(highest, later);
    }
    message.data[i] = occupancy_value(highest, scale);
  }
}

// Index (0, 0) is the corner of the largest x and y, column-major, with x and y descending: our order reversed.
void fill(grid_map_msgs::GridMap& message, const FrameResult& result) {
  const GridLayers& grid{result.world};
  const GridGeometry& geometry{grid.geometry};
  message.info.resolution = geometry.cell_size_m;
  message.info.length_x = geometry.nx * geometry.cell_size_m;
  message.info.length_y = geometry.ny * geometry.cell_size_m;
  message.info.pose.position = {geometry.x_min_m + message.info.length_x / 2,
                                geometry.y_min_m + message.info.length_y / 2, 0};
  const std::array<Layer, 5> filtered{{{"occupancy", &grid.occupancy},
                                       {"velocity_x", &grid.velocity_x},
                                       {"velocity_y", &grid.velocity_y},
                                       {"moving", &grid.moving},
                                       {"age", &grid.age_s}}};
  const std::array<Layer, 2> elevations{
      {{"elevation", &result.world_elevation_m}, {"elevation_sigma", &result.world_elevation_sigma_m}}};
  message.basic_layers.resize(1);
  message.basic_layers.front() = "occupancy";
  const std::size_t layers{filtered.size() + (result.world_elevation_m.empty() ? 0 : elevations.size()) +
                           (result.world_terrain.empty() ? 0 : 1) + (result.witness.empty() ? 0 : 1)};
  message.layers.resize(layers);
  message.data.resize(layers);
  std::size_t done{0};
  const auto cells_of_next = [&](const char* name) -> std::vector<float>& {
    message.layers[done] = name;
    std_msgs::Float32MultiArray& array{message.data[done++]};
    lay_out(array.layout, geometry.nx, geometry.ny);
    array.data.resize(grid.age_s.size());
    return array.data;
  };
  for (const Layer& layer : filtered) {
    // unobserved cells are NaN
    std::transform(layer.cells->begin(), layer.cells->end(), grid.age_s.begin(), cells_of_next(layer.name).rbegin(),
                   [](float cell, float age_s) { return std::isinf(age_s) ? not_a_number : cell; });
  }
  for (const Layer& layer : elevations) {
    if (!layer.cells->empty()) std::ranges::copy(*layer.cells, cells_of_next(layer.name).rbegin());
  }
  if (!result.world_terrain.empty()) {
    std::ranges::transform(result.world_terrain, cells_of_next("terrain").rbegin(),
                           [](TerrainClass kind) { return static_cast<float>(kind); });
  }
  if (result.witness.empty()) return;
  std::vector<float>& witnesses{cells_of_next("witness")};
  for_world_cells(result, result.witness, {}, [&](std::size_t i, CellWitness witness) {
    witnesses[witnesses.size() - 1 - i] = static_cast<float>(witness.byte);
  });
}

void fill(foxglove_msgs::Grid& message, const FrameResult& result) {
  const GridLayers& grid{result.world};
  const GridGeometry& geometry{grid.geometry};
  const bool has_elevation{!result.world_elevation_m.empty()};
  const std::size_t packed_bytes{has_elevation ? terrain_offset + 1 : elevation_offset};
  message.pose.position = {geometry.x_min_m, geometry.y_min_m, 0};
  message.column_count = static_cast<std::uint32_t>(geometry.nx);
  message.cell_size = {geometry.cell_size_m, geometry.cell_size_m};
  message.cell_stride = static_cast<std::uint32_t>(packed_bytes);
  message.row_stride = message.column_count * message.cell_stride;
  message.fields.resize(packed_fields.size() - (has_elevation ? 0 : 3));
  for (std::size_t i{0}; i < message.fields.size(); ++i) {
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
    pack_hundredths(grid.velocity_x.data()[i], cell + 2);
    pack_hundredths(grid.velocity_y.data()[i], cell + 4);
    cell[6] = packed_age(grid.age_s.data()[i]);
  }
  if (!has_elevation) return;
  for (std::size_t i{0}; i < cells; ++i) {
    std::uint8_t* const cell{message.data.data() + packed_bytes * i};
    pack_hundredths(result.world_elevation_m.data()[i], cell + elevation_offset);
    cell[terrain_offset] = static_cast<std::uint8_t>(result.world_terrain.data()[i]);
  }
  if (result.witness.empty()) return;
  for_world_cells(result, result.witness, {}, [&](std::size_t i, CellWitness witness) {
    message.data[packed_bytes * i + witness_offset] = witness.byte;
  });
}

}  // namespace stereogrid::messages
