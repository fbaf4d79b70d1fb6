// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "filter/filter.hpp"
#include "matching/matching.hpp"
#include "observation/projection/projection.hpp"
#include "observation/rays/rays.hpp"
#include "observation/u_disparity/u_disparity.hpp"
#include "pipeline/results.hpp"
#include "terrain/low_obstacles.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Working memory of predictions.
struct PredictionWorkspace {
  PredictionWorkspace(int cells, const FilterConfig& config)
      : state{cells, config}, layers{grid_layers({0, 0, 1, cells, cells})}, nothing{cells, cells, 0.5f} {}

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(state, layers, nothing); }

  FilterState state;
  GridLayers layers;
  Image<float> nothing;  ///< observed
};

/// Data of the stages on the host, and the filter's state between frames. Allocated once.
struct HostWorkspace {
  /// `filters` false: without what the filter needs.
  HostWorkspace(const Config& config, const Rig& level_rig, const GridGeometry& vehicle_grid, int threads,
                bool filters);

  [[nodiscard]] std::size_t memory_bytes() const;

  Image<std::uint8_t> aligned_right;
  Matches matches;
  Image<float> heights;             ///< working memory of split_surfaces
  SectorWalks walks;                ///< for GroundModel::terrain
  LowObstacleFinder low_obstacles;  ///< likewise
  MatchingWorkspace matching;
  UDisparityTables u_disparity_tables;
  UDisparityWorkspace u_disparity;
  ProjectionWorkspace projection;
  RayWorkspace rays;
  FilterTables filter_tables;
  Image<float> observed_world;
  FilterState filtered;                             ///< state of the last published frame
  FilterState next;                                 ///< written by the frame in work
  std::unique_ptr<PredictionWorkspace> prediction;  ///< null: no predictions
  WeighingWorkspace weighing;
  std::vector<BlockKind> block_kinds;  ///< kinds of the window's layers of the stored result: FilterState::kinds
  std::vector<BlockKind> part_kinds;   ///< kinds of its vehicle's layers, see KnownKinds
};

inline HostWorkspace::HostWorkspace(const Config& config, const Rig& level_rig, const GridGeometry& vehicle_grid,
                                    int threads, bool filters)
    : aligned_right{level_rig.width_px, level_rig.height_px},
      matches{level_rig.width_px, level_rig.height_px},
      heights{level_rig.width_px, level_rig.height_px},
      walks{config.ground.model == GroundModel::terrain ? level_rig : Rig{}, rings_of(config).capacity(),
            config.matching.window_px},
      low_obstacles{config.ground.model == GroundModel::terrain ? level_rig : Rig{},
                    config.ground.model == GroundModel::terrain ? Window{vehicle_grid}.cells() : 0},
      matching{level_rig.width_px, level_rig.height_px, config.matching, threads},
      u_disparity_tables{{config.u_disparity, config.paper}, level_rig.height_px, config.matching.window_px},
      u_disparity{level_rig.width_px, level_rig.height_px, config.matching.disparities, threads},
      projection{level_rig.width_px, config.matching.disparities},
      rays{level_rig.width_px, level_rig.height_px,
           config.projection.model == ProjectionModel::rays ? config.matching.disparities : 0,
           config.ground.model == GroundModel::terrain},
      filter_tables{config.filter},
      observed_world{Window{vehicle_grid}.cells(), Window{vehicle_grid}.cells()},
      filtered{filters ? Window{vehicle_grid}.cells() : 0, config.filter},
      next{filtered.occupancy.width(), config.filter},
      weighing{filtered.occupancy.width(), filter_tables, config.filter.model == FilterModel::joint ? threads : 0},
      block_kinds(filtered.kinds.size()),
      part_kinds(static_cast<std::size_t>(vehicle_grid.ny * resampled_parts(vehicle_grid.nx))) {
  if (config.projection.model != ProjectionModel::rays) projection.plan(BinGeometry{level_rig}, {vehicle_grid});
}

inline std::size_t HostWorkspace::memory_bytes() const {
  return memory_bytes_of(aligned_right, matches, heights, walks, low_obstacles, matching, u_disparity_tables,
                         u_disparity, projection, rays, filter_tables, observed_world, filtered, next, weighing,
                         block_kinds, part_kinds) +
         (prediction ? sizeof(PredictionWorkspace) + prediction->memory_bytes() : 0);
}

}  // namespace stereogrid
