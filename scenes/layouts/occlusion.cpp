// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {

World build_occlusion(const SceneOptions& options) {
  World world;
  world.seed = options.seed;
  world.road = two_lanes(3.5, 0);
  Random random{options.seed};
  world.add(make_crate({6.4, 0, 0}, {0.8, 1.2, 1.0}, random));
  world.add(make_person({8.4, 0.1, pi / 2}, random));
  world.add(make_wall({16.2, 0, pi / 2}, 30, 2.6, random));
  world.add(make_car({10.5, -4.2, 0.1}, random));
  world.add(make_van({11.5, 4.6, pi / 2 + 0.4}, random));
  world.add(make_pole({9.0, 2.2, 0}, 3.2, random));
  world.add(make_tree({19.5, -2.5, 0}, random));
  return world;
}

}  // namespace stereogrid::scenes
