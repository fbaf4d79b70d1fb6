// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/results.hpp"

#include <algorithm>
#include <cmath>

#include "filter/filter.hpp"
#include "obstacles/tracking.hpp"

namespace stereogrid {
namespace {

StageImages stage_images(int width, int height, int bins, int bins_per_px) {
  return {Image<float>{width, height},       Image<float>{width, height},
          Image<float>{width, height},       std::vector<int>(static_cast<std::size_t>(bins)),
          Image<std::uint16_t>{width, bins}, Image<std::uint16_t>{width, bins},
          Image<float>{width, bins},         Image<float>{width, bins},
          Image<float>{width, bins},         Image<float>{width, bins},
          Image<float>{width, bins},         bins_per_px};
}

}  // namespace

GridGeometry vehicle_grid_of(const GridConfig& config) {
  return {0, -config.width_m / 2, config.cell_size_m,
          static_cast<int>(std::lround(config.length_m / config.cell_size_m)),
          static_cast<int>(std::lround(config.width_m / config.cell_size_m))};
}

FrameResult empty_result(const Config& config, const Rig& rig) {
  FrameResult result;
  result.vehicle = grid_layers(vehicle_grid_of(config.grid));
  result.observed = Image<float>{result.vehicle.geometry.nx, result.vehicle.geometry.ny};
  const int window_cells{Window{result.vehicle.geometry}.cells()};
  result.world = grid_layers({0, 0, config.grid.cell_size_m, window_cells, window_cells});
  result.stages = stage_images(rig.width_px, rig.height_px, bins_of(config), config.u_disparity.bins_per_px);
  result.obstacles.reserve(things_reserved);
  result.status.reserve(names_of(FrameStatus{}).size());
  return result;
}

std::size_t held_bytes(const GridLayers& layers) {
  return held_bytes_of(layers.occupancy, layers.velocity_x, layers.velocity_y, layers.age_s, layers.velocity_xx,
                       layers.velocity_xy, layers.velocity_yy, layers.moving);
}

std::size_t held_bytes(const StageImages& stages) {
  return held_bytes_of(stages.obstacle_disparity, stages.road_disparity, stages.match_confidence, stages.possible,
                       stages.visible, stages.observed, stages.visibility, stages.obstacle_confidence,
                       stages.road_confidence, stages.occupancy, stages.occupancy_smooth);
}

std::size_t held_bytes(const FrameResult& result) {
  std::size_t bytes{
      held_bytes_of(result.observed, result.vehicle, result.world, result.obstacles, result.stages, result.status)};
  bytes += result.predictions.capacity() * sizeof(Prediction);
  for (const Prediction& one : result.predictions) bytes += held_bytes_of(one.occupancy, one.world_occupancy);
  return bytes;
}

int bins_of(const Config& config) {
  return config.matching.disparities * config.u_disparity.bins_per_px;
}

double share_matched(const Image<float>& disparity) {
  const auto matched{std::count_if(disparity.begin(), disparity.end(), [](float d) { return d > 0; })};
  return static_cast<double>(matched) / static_cast<double>(disparity.size());
}

}  // namespace stereogrid
