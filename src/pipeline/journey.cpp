// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/journey.hpp"

namespace stereogrid {

JourneyMemory::JourneyMemory(const Config& parameters, const Rig& level_rig, const GridGeometry& vehicle_grid,
                             int threads)
    : config{parameters},
      rig{level_rig},
      ground{calibrated_ground(rig, config.ground)},
      trust{rig, config.ground},
      alignment{rig},
      aligned_right{rig.width_px, rig.height_px},
      matches{rig.width_px, rig.height_px},
      matching{rig.width_px, rig.height_px, config.matching, threads},
      ground_samples{rig.width_px, rig.height_px},
      u_disparity_tables{config.u_disparity, rig.height_px, config.matching.window_px},
      u_disparity{rig.width_px, rig.height_px, bins_of(config), threads},
      projection{rig.width_px, bins_of(config)},
      window{vehicle_grid},
      filter_tables{config.filter},
      observed_world{window.cells(), window.cells()},
      filtered{window.cells(), config.filter},
      filtered_before{filtered},
      scene_flow{rig},
      velocity_evidence{window.cells(), filter_tables.axis_mps.back()},
      weighing{window.cells(), filter_tables, config.filter.model == FilterModel::joint ? threads : 0},
      clusters{window.cells(), window.cells(), scene_flow.points_reserved()},
      tracker{config.tracking} {
  projection.plan(BinGeometry{rig, config.u_disparity.bins_per_px}, {vehicle_grid}, config.projection.footprint);
}

std::size_t JourneyMemory::held_bytes() const {
  return held_bytes_of(alignment, trust, aligned_right, matches, matching, ground_samples, u_disparity_tables,
                       u_disparity, projection, filter_tables, observed_world, filtered, filtered_before, scene_flow,
                       velocity_evidence, weighing, clusters, tracker) +
         (outlook ? sizeof(Outlook) + outlook->held_bytes() : 0);
}

// The rest is working memory, or the first frame resets it.
void JourneyMemory::forget() {
  ground = calibrated_ground(rig, config.ground);
  frames_to_search = 0;
  is_first = true;
  alignment = RowAlignment{rig};
  trust = FrameTrust{rig, config.ground};
  scene_flow = SceneFlow{rig};
  tracker.forget();
}

}  // namespace stereogrid
