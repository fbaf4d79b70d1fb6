// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double following_mps{5};
constexpr double van_speed_mps{4};
constexpr double van_ahead_m{10.6};  ///< its middle; its back is 2.6 m nearer

}  // namespace

World build_van(const SceneOptions& options) {
  const double duration_s{options.frames / options.rate_hz};
  World world;
  world.seed = options.seed;
  world.ego.speed_mps = following_mps;
  world.road = two_lanes(3.0, 0);
  Random random{options.seed};
  Body van{make_van({van_ahead_m, 0, 0}, random)};
  van.motion.speed_mps = van_speed_mps;
  van.motion.end_s = 4;  // then it stands
  world.add(van);
  const double length_m{following_mps * duration_s + 80};
  world.add(make_wall({length_m / 2 - 10, 2.6, 0}, length_m, 3, random));
  for (double along{-8}; along < length_m; along += 4) world.add(make_pavement({along, -3.0, 0}, 4.2, 2.6));
  world.add(make_wall({length_m / 2 - 10, -4.5, 0}, length_m, 5, random));
  return world;
}

}  // namespace stereogrid::scenes
