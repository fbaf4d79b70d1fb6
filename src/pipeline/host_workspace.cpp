// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/host_workspace.hpp"

namespace stereogrid {

HostWorkspace::HostWorkspace(const Config& config, const Rig& level_rig, const GridGeometry& vehicle_grid, int threads)
    : aligned_right{level_rig.width_px, level_rig.height_px},
      matches{level_rig.width_px, level_rig.height_px},
      heights{level_rig.width_px, level_rig.height_px},
      matching{level_rig.width_px, level_rig.height_px, config.matching, threads},
      u_disparity_tables{{config.u_disparity, config.paper}, level_rig.height_px, config.matching.window_px},
      u_disparity{level_rig.width_px, level_rig.height_px, config.matching.disparities, threads},
      projection{level_rig.width_px, config.matching.disparities},
      rays{level_rig.width_px, level_rig.height_px,
           config.projection.model == ProjectionModel::rays ? config.matching.disparities : 0,
           config.ground.model == GroundModel::terrain},
      filter_tables{config.filter},
      observed_world{Window{vehicle_grid}.cells(), Window{vehicle_grid}.cells()},
      filtered{Window{vehicle_grid}.cells(), config.filter},
      next{Window{vehicle_grid}.cells(), config.filter},
      weighing{Window{vehicle_grid}.cells(), filter_tables, config.filter.model == FilterModel::joint ? threads : 0},
      block_kinds(filtered.kinds.size()),
      part_kinds(static_cast<std::size_t>(vehicle_grid.ny * resampled_parts(vehicle_grid.nx))) {
  if (config.projection.model != ProjectionModel::rays) projection.plan(BinGeometry{level_rig}, {vehicle_grid});
}

std::size_t HostWorkspace::memory_bytes() const {
  return memory_bytes_of(aligned_right, matches, heights, matching, u_disparity_tables, u_disparity, projection, rays,
                         filter_tables, observed_world, filtered, next, weighing, block_kinds, part_kinds) +
         (prediction ? sizeof(PredictionWorkspace) + prediction->memory_bytes() : 0);
}

}  // namespace stereogrid
