// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/run_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string_view>

#include "stereogrid/io/npz.hpp"

namespace stereogrid::io {
namespace {

using Layers = std::vector<std::reference_wrapper<const Image<float>>>;

/// Several grids as one array of halves, (ny, nx) or (n, ny, nx). Steps whose numbers end in zeros pack well.
struct CompactStack {
  CompactStack(const Layers& layers, float steps_per_unit) {
    const Image<float>& first{layers.front()};
    shape = {static_cast<std::size_t>(first.height()), static_cast<std::size_t>(first.width())};
    if (layers.size() > 1) shape.insert(shape.begin(), layers.size());
    for (const Image<float>& layer : layers) {
      for (const float value : layer) values.emplace_back(std::round(value * steps_per_unit) / steps_per_unit);
    }
  }
  [[nodiscard]] NpzArray named(const char* name) const { return {name, shape, values}; }

  std::vector<std::size_t> shape;
  std::vector<Half> values;
};

/// An array of grids/NAME.npz.
struct GridArray {
  const char* name;
  float steps_per_unit;  ///< for write_compact_grids; 0: not written
  Layers (*grids)(const FrameResult&);
};

/// Arrays of a byte a cell, by write_grids.
struct ByteArray {
  const char* name;
  std::span<const std::uint8_t> (*cells)(const FrameResult&);
};

template <class Byte>
std::span<const std::uint8_t> bytes_of(const Image<Byte>& image) {
  static_assert(sizeof(Byte) == 1);
  return {reinterpret_cast<const std::uint8_t*>(image.data()), image.size()};
}

constexpr std::array<ByteArray, 3> byte_arrays{{
    {"terrain", [](const FrameResult& r) { return bytes_of(r.terrain); }},
    {"witness", [](const FrameResult& r) { return bytes_of(r.witness); }},
    {"world_terrain", [](const FrameResult& r) { return bytes_of(r.world_terrain); }},
}};

constexpr const char* of_world{"world_"};
constexpr float of_one{256};
constexpr float of_mps{16};
constexpr float of_second{64};

Layers covariance_of(const GridLayers& grid) {
  return {grid.velocity_xx, grid.velocity_xy, grid.velocity_yy};
}

const std::array<GridArray, 15> all_arrays{{
    {"observed", of_one, [](const FrameResult& r) { return Layers{r.observed}; }},
    {"elevation_m", 0, [](const FrameResult& r) { return Layers{r.elevation_m}; }},
    {"elevation_sigma_m", 0, [](const FrameResult& r) { return Layers{r.elevation_sigma_m}; }},
    {"occupancy", of_one, [](const FrameResult& r) { return Layers{r.vehicle.occupancy}; }},
    {"moving", of_one, [](const FrameResult& r) { return Layers{r.vehicle.moving}; }},
    {"age_s", of_second, [](const FrameResult& r) { return Layers{r.vehicle.age_s}; }},
    {"velocity", of_mps,
     [](const FrameResult& r) {
       return Layers{r.vehicle.velocity_x, r.vehicle.velocity_y};
     }},
    {"velocity_covariance", 0, [](const FrameResult& r) { return covariance_of(r.vehicle); }},
    {"world_occupancy", 0, [](const FrameResult& r) { return Layers{r.world.occupancy}; }},
    {"world_moving", 0, [](const FrameResult& r) { return Layers{r.world.moving}; }},
    {"world_age_s", 0, [](const FrameResult& r) { return Layers{r.world.age_s}; }},
    {"world_velocity", 0,
     [](const FrameResult& r) {
       return Layers{r.world.velocity_x, r.world.velocity_y};
     }},
    {"world_elevation_m", 0, [](const FrameResult& r) { return Layers{r.world_elevation_m}; }},
    {"world_elevation_sigma_m", 0, [](const FrameResult& r) { return Layers{r.world_elevation_sigma_m}; }},
    {"world_velocity_covariance", 0, [](const FrameResult& r) { return covariance_of(r.world); }},
}};

bool is_among(const std::vector<std::string>& layers, const std::string& name) {
  return layers.empty() || std::ranges::find(layers, name) != layers.end();
}

}  // namespace

std::vector<std::string> grid_arrays(bool compact) {
  std::vector<std::string> names;
  for (const GridArray& array : all_arrays) {
    if (!compact || array.steps_per_unit > 0) names.emplace_back(array.name);
  }
  if (compact) return names;
  for (const ByteArray& array : byte_arrays) names.emplace_back(array.name);
  return names;
}

void write_compact_grids(const std::filesystem::path& path, const FrameResult& result,
                         const std::vector<std::string>& layers) {
  std::vector<CompactStack> stacks;
  std::vector<NpzArray> arrays;
  stacks.reserve(all_arrays.size());  // arrays point into them
  for (const GridArray& array : all_arrays) {
    if (array.steps_per_unit == 0 || !is_among(layers, array.name)) continue;
    arrays.push_back(stacks.emplace_back(array.grids(result), array.steps_per_unit).named(array.name));
  }
  write_npz(path, arrays);
}

void write_grids(const std::filesystem::path& path, const FrameResult& result, const std::vector<std::string>& layers) {
  std::vector<NpzArray> arrays;
  bool has_world{false};
  for (const GridArray& array : all_arrays) {
    if (!is_among(layers, array.name)) continue;
    has_world |= std::string_view{array.name}.starts_with(of_world);
    const Layers grids{array.grids(result)};
    if (grids.front().get().empty()) continue;  // no elevation without GroundModel::terrain
    if (grids.size() == 1) {
      arrays.emplace_back(array.name, grids.front().get());
    } else {
      arrays.emplace_back(array.name, grids);
    }
  }
  for (const ByteArray& array : byte_arrays) {
    const std::span<const std::uint8_t> cells{array.cells(result)};
    if (cells.empty() || !is_among(layers, array.name)) continue;  // likewise
    const bool is_of_world{std::string_view{array.name}.starts_with(of_world)};
    const GridGeometry& grid{is_of_world ? result.world.geometry : result.vehicle.geometry};
    arrays.push_back({array.name, {static_cast<std::size_t>(grid.ny), static_cast<std::size_t>(grid.nx)}, cells});
  }
  const std::vector<double> origin{result.world.geometry.x_min_m, result.world.geometry.y_min_m};
  if (has_world) arrays.push_back({"world_origin", {2}, origin});
  write_npz(path, arrays);
}

void write_predictions(const std::filesystem::path& path, const FrameResult& result) {
  std::vector<double> horizons_s;
  Layers vehicle;
  Layers world;
  for (const Prediction& prediction : result.predictions) {
    horizons_s.push_back(prediction.horizon_s);
    vehicle.emplace_back(prediction.occupancy);
    world.emplace_back(prediction.world_occupancy);
  }
  const std::vector<double> origin{result.world.geometry.x_min_m, result.world.geometry.y_min_m};
  const std::array<NpzArray, 4> arrays{
      NpzArray{"horizon_s", {horizons_s.size()}, horizons_s},
      NpzArray{"occupancy", vehicle},
      NpzArray{"world_occupancy", world},
      NpzArray{"world_origin", {2}, origin},
  };
  write_npz(path, arrays);
}

void write_stages(const std::filesystem::path& path, const StageImages& stages) {
  const std::array<NpzArray, 12> arrays{
      NpzArray{"obstacle_disparity", stages.obstacle_disparity},
      NpzArray{"road_disparity", stages.road_disparity},
      NpzArray{"match_confidence", stages.match_confidence},
      NpzArray{"ambiguous", stages.ambiguous},
      NpzArray{"possible", {stages.possible.size()}, stages.possible},
      NpzArray{"visible", stages.visible},
      NpzArray{"observed_pixels", stages.observed},
      NpzArray{"visibility", stages.visibility},
      NpzArray{"obstacle_confidence", stages.obstacle_confidence},
      NpzArray{"road_confidence", stages.road_confidence},
      NpzArray{"u_occupancy", stages.occupancy},
      NpzArray{"u_occupancy_smooth", stages.occupancy_smooth},
  };
  write_npz(path, arrays);
}

}  // namespace stereogrid::io
