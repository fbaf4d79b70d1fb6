// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "ground/ground_estimator.hpp"
#include "ground/own_surface.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "memory_bytes.hpp"
#include "motion/scene_flow.hpp"
#include "obstacles/tracking/near_obstacles.hpp"
#include "pipeline/results.hpp"
#include "terrain/frame_terrain.hpp"

namespace stereogrid {

/// All of a camera that crosses frames: saved, loaded, reset and counted as one. The state of the filter lies where the
/// stages work.
struct CameraState {
  CameraState(const Config& config, const Rig& level_rig, const GroundState& first_ground, int window_cells)
      : ground{first_ground},
        own_surface{level_rig},
        alignment{level_rig},
        scene_flow{level_rig},
        near{level_rig, config.matching, window_cells} {
    if (config.ground.model == GroundModel::terrain)
      terrain.emplace(level_rig, config, vehicle_grid_of(config.grid), window_cells);
  }

  /// Makes the next frame a first one.
  void reset(const Rig& level_rig, const GroundState& first_ground) {
    is_first = true;
    ground = first_ground;
    own_surface = OwnSurface{level_rig};
    alignment = RowAlignment{level_rig};
    scene_flow = SceneFlow{level_rig};
    near.clear();
    if (terrain) terrain->reset();
  }

  template <class State>
  void exchange(State& state) {
    state(is_first, ground, own_surface, alignment, scene_flow, near);
    if (terrain) state(*terrain);
  }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(own_surface, alignment, scene_flow, near) + (terrain ? memory_bytes_of(*terrain) : 0);
  }

  bool is_first{true};
  GroundState ground;
  OwnSurface own_surface;  ///< not updated with GroundMode::given
  RowAlignment alignment;
  SceneFlow scene_flow;
  NearObstacles near;
  std::optional<FrameTerrain> terrain{};  ///< GroundModel::terrain
};

}  // namespace stereogrid
