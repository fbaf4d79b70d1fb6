// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"

namespace stereogrid::scenes {

World build_empty(const SceneOptions& options) {
  World world;
  world.seed = options.seed;
  world.road = two_lanes(3.5, 0);
  world.ego.speed_mps = 5;
  return world;
}

}  // namespace stereogrid::scenes
