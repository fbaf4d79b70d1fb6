// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {
namespace {

void add_background(World& world, Random& random) {
  world.add(make_pavement({20, 0, pi / 2}, 80, 5));
  for (int i{-3}; i <= 3; ++i) {
    world.add(make_house({26, 11.0 * i, pi / 2}, 11, 7.2, random.between(6, 11), random), pavement_height_m);
  }
  for (const double side : {-1.0, 1.0}) {
    world.add(make_pavement({4.2, side * 9.5, 0}, 10, 4));
    world.add(make_house({4.2, side * 15, 0}, 10, 7, random.between(6, 9), random), pavement_height_m);
  }
  world.add(make_tree({18.5, 7.5, 0}, random), pavement_height_m);
  world.add(make_tree({18.6, -8.5, 0}, random), pavement_height_m);
  world.add(make_pole({18.2, 3.0, 0}, 4, random), pavement_height_m);
  world.add(make_pole({8.6, -7.9, 0}, 3.2, random), pavement_height_m);
  world.add(make_car({16.3, -4.5, pi / 2}, random));
  world.add(make_crate({8.5, 8.0, 0.3}, {0.8, 0.9, 1.1}, random), pavement_height_m);
}

}  // namespace

World build_crossing(const SceneOptions& options) {
  World world;
  world.seed = options.seed;
  world.road = two_lanes(3.5, 0);
  for (Paint& line : world.road.paint) line.along_max_m = 6.5;
  for (int bar{-3}; bar <= 3; ++bar) world.road.paint.push_back({7.0, 9.5, bar - 0.25, bar + 0.25, 0, 0});
  Random random{options.seed};
  Body walker{make_person({8, -2.8, pi / 2}, random)};
  walker.motion.speed_mps = 1.4;
  world.add(walker);
  Body car{make_car({13, 11, -pi / 2}, random)};
  car.motion.speed_mps = 6;
  world.add(car);
  add_background(world, random);
  return world;
}

}  // namespace stereogrid::scenes
