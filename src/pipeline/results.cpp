// SPDX-License-Identifier: Apache-2.0
#include "pipeline/results.hpp"

#include <cmath>

#include "filter/filter.hpp"
#include "geometry/matches.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "terrain/frame_terrain.hpp"

namespace stereogrid {
namespace {

template <class T>
void make_room(int width, int height, Image<T>& image) {
  if (image.width() != width || image.height() != height) image = Image<T>{width, height};
}

void make_room(const GridGeometry& geometry, GridLayers& layers) {
  layers.geometry = geometry;
  for (Image<float>* image : {&layers.occupancy, &layers.velocity_x, &layers.velocity_y, &layers.age_s,
                              &layers.velocity_xx, &layers.velocity_xy, &layers.velocity_yy, &layers.moving}) {
    make_room(geometry.nx, geometry.ny, *image);
  }
}

}  // namespace

GridGeometry vehicle_grid_of(const GridConfig& config) {
  const double behind{std::round(config.rear_m / config.cell_size_m)};
  return {0 - behind * config.cell_size_m, -config.width_m / 2, config.cell_size_m,
          static_cast<int>(std::lround(config.length_m / config.cell_size_m) + std::lround(behind)),
          static_cast<int>(std::lround(config.width_m / config.cell_size_m))};
}

void make_room(const Config& config, const Rig& rig, StageImages& stages) {
  const int bins{config.matching.disparities};
  for (Image<float>* image : {&stages.obstacle_disparity, &stages.road_disparity, &stages.match_confidence}) {
    make_room(rig.width_px, rig.height_px, *image);
  }
  make_room(rig.width_px, rig.height_px, stages.ambiguous);
  stages.possible.resize(static_cast<std::size_t>(bins));
  for (Image<std::uint16_t>* image : {&stages.visible, &stages.observed}) make_room(rig.width_px, bins, *image);
  for (Image<float>* image : {&stages.visibility, &stages.obstacle_confidence, &stages.road_confidence,
                              &stages.occupancy, &stages.occupancy_smooth}) {
    make_room(rig.width_px, bins, *image);
  }
}

void make_room(const Config& config, const std::vector<double>& horizons_s, FrameResult& result) {
  const GridGeometry vehicle{vehicle_grid_of(config.grid)};
  const int window_cells{Window{vehicle}.cells()};
  make_room(vehicle.nx, vehicle.ny, result.observed);
  if (config.ground.model == GroundModel::terrain) {
    const auto resize = [](int nx, int ny, auto&... images) { (make_room(nx, ny, images), ...); };
    resize(vehicle.nx, vehicle.ny, result.elevation_m, result.elevation_sigma_m, result.terrain, result.witness);
    resize(window_cells, window_cells, result.world_elevation_m, result.world_elevation_sigma_m, result.world_terrain);
  }
  make_room(vehicle, result.vehicle);
  make_room({0, 0, config.grid.cell_size_m, window_cells, window_cells}, result.world);
  result.predictions.resize(horizons_s.size());
  for (std::size_t i{0}; i < horizons_s.size(); ++i) {
    Prediction& prediction{result.predictions[i]};
    prediction.horizon_s = horizons_s[i];
    make_room(vehicle.nx, vehicle.ny, prediction.occupancy);
    make_room(window_cells, window_cells, prediction.world_occupancy);
  }
  result.obstacles.reserve(things_reserved);
  result.status.reserve(names_of(FrameStatus{}).size());
}

void begin_camera(const Config& config, FrameResult& seen) {
  const GridGeometry vehicle{vehicle_grid_of(config.grid)};
  make_room(vehicle.nx, vehicle.ny, seen.observed);
  seen.observed.fill(0.5f);
  if (config.ground.model == GroundModel::terrain) {
    make_room(vehicle.nx, vehicle.ny, seen.elevation_m);
    make_room(vehicle.nx, vehicle.ny, seen.elevation_sigma_m);
    make_room(vehicle.nx, vehicle.ny, seen.terrain);
    FrameTerrain::clear(seen);
  }
  seen.vehicle.geometry = vehicle;
  seen.has_images = false;
  seen.status.clear();
  seen.warnings.clear();
}

void set_obstacles(View<const float> matched, StageImages& stages) {
  for (int v{0}; v < matched.height; ++v) {
    const float* const from{matched.row(v)};
    float* const disparity{stages.obstacle_disparity.row(v)};
    std::uint8_t* const ambiguous{stages.ambiguous.row(v)};
    for (int u{0}; u < matched.width; ++u) {
      ambiguous[u] = is_ambiguous(from[u]) ? 1 : 0;
      disparity[u] = from[u] + 0.0f;  // without the sign of ambiguous_px
    }
  }
}

FrameResult empty_result(const Config& config, const Rig& rig) {
  FrameResult result;
  make_room(config, {}, result);
  make_room(config, rig, result.stages);
  return result;
}

std::size_t memory_bytes(const GridLayers& layers) {
  return memory_bytes_of(layers.occupancy, layers.velocity_x, layers.velocity_y, layers.age_s, layers.velocity_xx,
                         layers.velocity_xy, layers.velocity_yy, layers.moving);
}

std::size_t memory_bytes(const StageImages& stages) {
  return memory_bytes_of(stages.obstacle_disparity, stages.road_disparity, stages.match_confidence, stages.ambiguous,
                         stages.possible, stages.visible, stages.observed, stages.visibility,
                         stages.obstacle_confidence, stages.road_confidence, stages.occupancy, stages.occupancy_smooth);
}

std::size_t memory_bytes(const FrameResult& result) {
  std::size_t bytes{memory_bytes_of(result.observed, result.elevation_m, result.elevation_sigma_m, result.terrain,
                                    result.witness, result.world_elevation_m, result.world_elevation_sigma_m,
                                    result.world_terrain, result.vehicle, result.world, result.obstacles, result.stages,
                                    result.status, result.cameras)};
  bytes += result.predictions.capacity() * sizeof(Prediction);
  for (const Prediction& one : result.predictions) bytes += memory_bytes_of(one.occupancy, one.world_occupancy);
  return bytes;
}

double share_matched(const Image<float>& disparity) {
  std::ptrdiff_t matched{0};
  for (int v{0}; v < disparity.height(); ++v) {  // in rows, whose counts are as wide as the disparities
    const float* const row{disparity.row(v)};
    int of_row{0};
    for (int u{0}; u < disparity.width(); ++u) of_row += row[u] > 0 ? 1 : 0;
    matched += of_row;
  }
  return static_cast<double>(matched) / static_cast<double>(disparity.size());
}

}  // namespace stereogrid
