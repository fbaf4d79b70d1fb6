// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "journey.hpp"

namespace stereogrid {

JourneyMemory::JourneyMemory(const Config& parameters, const Rig& level_rig, const GridGeometry& vehicle_grid,
                             int threads)
    : config{parameters},
      rig{level_rig},
      ground{calibrated_ground(rig, config.ground)},
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
      cluster_labels{window.cells(), window.cells()},
      tracker{config.tracking} {
  projection.plan(BinGeometry{rig, config.u_disparity.bins_per_px}, {vehicle_grid}, config.projection.footprint);
}

// The rest is working memory, or the first frame resets it.
void JourneyMemory::forget() {
  ground = calibrated_ground(rig, config.ground);
  frames_to_search = 0;
  is_first = true;
  alignment = RowAlignment{rig};
  scene_flow = SceneFlow{rig};
  tracker.forget();
}

}  // namespace stereogrid
