// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {

World build_boxes(const SceneOptions& options) {
  World world;
  world.seed = options.seed;
  world.road = two_lanes(3.5, 0);
  Random random{options.seed};
  world.add(make_pavement({20, -7.5, 0}, 40, 3));
  world.add(make_wall({30.2, 0, pi / 2}, 60, 3, random));
  double left_m{-4};
  for (const double height_m : {0.1, 0.15, 0.2, 0.3, 0.5}) {
    world.add(make_crate({8.2, left_m, 0}, {0.4, 0.6, height_m}, random));
    world.add(make_crate({14.2, left_m - 1, 0}, {0.4, 0.6, height_m}, random));
    left_m += 2;
  }
  return world;
}

}  // namespace stereogrid::scenes
