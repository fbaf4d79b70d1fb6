// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/filter.hpp"
#include "support.hpp"
#include "terrain/frame_terrain.hpp"
#include "terrain/low_obstacles.hpp"
#include "terrain_walk.hpp"

namespace stereogrid::test {

/// The stage of frames with a height field ahead.
struct FrameOf {
  explicit FrameOf(const HeightField& height) {
    const GridGeometry& grid{vehicle.grid};
    result.elevation_m = result.elevation_sigma_m = Image<float>{grid.nx, grid.ny};
    result.terrain = Image<TerrainClass>{grid.nx, grid.ny};
    result.witness = Image<CellWitness>{grid.nx, grid.ny};
    result.observed = Image<float>{grid.nx, grid.ny};
    const int cells{window.cells()};
    result.world_elevation_m = result.world_elevation_sigma_m = Image<float>{cells, cells};
    result.world_terrain = Image<TerrainClass>{cells, cells};
    see(disparity_of(vehicle.rig, height));
  }
  static constexpr auto in_order = [](int count, const auto& work) { work(0, count); };
  void see(const Image<float>& disparity, double dt_s = 0.1) {
    Ground ground;
    ground.height_m = vehicle.rig.camera_height_m;
    ground.estimated = is_ground_measured;
    const Image<float> none{vehicle.rig.width_px, vehicle.rig.height_px};
    const GridGeometry cells{window.at(pose)};
    const GridInVehicle window_cells{grid_in_vehicle(cells, inverse(pose))};
    terrain.move({cells, window_cells, pose, dt_s, grid_in_vehicle(vehicle.grid, {}), window_cells});
    terrain.begin(ground, ground);
    terrain.set_noise(walks.begin(terrain.walk_frame(), disparity.view(), none.view(), in_order));
    terrain.set_walked(walks.find(in_order));
    const LowModel& model{terrain.begin_low_obstacles()};
    terrain.find_ground(in_order, result);
    terrain.mark_low_obstacles(low.find(disparity.view(), none.view(), model, terrain.noise_px(), in_order), result);
  }
  /// Highest filtered occupancy at x in front of the vehicle, if the filter has only seen free cells.
  float filtered_at(double x, bool is_usable = true, const std::function<bool(Point2)>& claims_free = {}) {
    result.vehicle = grid_layers(vehicle.grid);
    result.world = grid_layers(window.at(pose));
    result.observed.fill(0);
    const std::array<const FrameTerrain*, 1> all{&terrain};
    const std::span seen{std::span{all}.first(is_usable ? 1 : 0)};
    terrain.find_bounds(seen, claims_free, in_order, result);
    bound_grids(terrain.add_bars(seen, std::as_const(result.world.occupancy).view()), result);
    terrain.remember_elevation(seen, result);
    terrain.classify(result);
    float highest{0};
    for (const double near : {x - 0.2, x, x + 0.2}) {
      const Point2 world{pose * Point2{near, 0}};
      const GridGeometry& grid{result.world.geometry};
      const float there{result.world.occupancy(static_cast<int>((world.x - grid.x_min_m) / grid.cell_size_m),
                                               static_cast<int>((world.y - grid.y_min_m) / grid.cell_size_m))};
      highest = std::max(
          {highest, std::min(there, result.vehicle.occupancy(static_cast<int>(near / 0.2), vehicle.grid.ny / 2))});
    }
    return highest;
  }
  static Config config() {
    Config config;
    config.matching.disparities = 64;
    return config;
  }
  [[nodiscard]] CellRule rule_at(double x) const {
    return terrain.rules().vehicle(static_cast<int>(x / vehicle.grid.cell_size_m), vehicle.grid.ny / 2);
  }

  [[nodiscard]] CellWitness witness_at(double x) const {
    return result.witness(static_cast<int>(x / vehicle.grid.cell_size_m), vehicle.grid.ny / 2);
  }

  Vehicle vehicle{car()};
  Window window{vehicle.grid};
  SectorWalks walks{vehicle.rig, rings_of(config()).capacity(), config().matching.window_px};
  LowObstacleFinder low{vehicle.rig, window.cells()};
  FrameTerrain terrain{vehicle.rig, config(), vehicle.grid, window.cells()};
  Pose2 pose{};
  bool is_ground_measured{true};
  FrameResult result;
};

}  // namespace stereogrid::test
