// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {

World build_wall(const SceneOptions& options) {
  World world;
  world.seed = options.seed;
  world.road = two_lanes(3.5, 0);
  Random random{options.seed};
  world.add(make_wall({8.2, 0, pi / 2}, 40, 3, random));
  return world;
}

}  // namespace stereogrid::scenes
