// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "layouts/layouts.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double approach_m{4};
constexpr double approach_mps{2};

// The vehicle drives for two seconds and stands `edge_m` before x = approach_m + edge_m from then on.
World approached(std::uint64_t seed) {
  World world;
  world.seed = seed;
  world.road.centre_left_m = 1e3;  // no markings
  world.ego.speed_mps = approach_mps;
  world.ego.end_s = approach_m / approach_mps;
  return world;
}

}  // namespace

World build_step(const SceneOptions& options) {
  constexpr double tread_m{0.3};
  World world{approached(options.seed)};
  const Direction incline{direction_of(options.incline_deg * pi / 180)};
  const double rise_m{options.rise_m / options.steps};
  const double run_m{options.incline_deg < 90 ? std::abs(rise_m) * incline.cosine / incline.sine : 0};
  Profile::Point at{approach_m + options.edge_m, 0};
  std::vector<Profile::Point> points{at};
  for (int step{0}; step < options.steps; ++step) {
    at = {at.x + run_m, at.z + rise_m};
    points.push_back(at);
    if (step + 1 == options.steps) break;
    at.x += tread_m;
    points.push_back(at);
  }
  world.ground = Profile{points};
  return world;
}

World build_table(const SceneOptions& options) {
  constexpr double top_m{0.04};
  World world{approached(options.seed)};
  Random random{options.seed};
  const double middle_m{approach_m + options.edge_m + 0.8};
  Body top{make_crate({middle_m, 0, 0}, {1.6, 2.4, top_m}, random)};
  world.add(top, options.rise_m - top_m);
  for (const double x : {-0.7, 0.7}) {
    for (const double y : {-1.1, 1.1}) {
      world.add(make_crate({middle_m + x, y, 0}, {0.06, 0.06, options.rise_m - top_m}, random));
    }
  }
  return world;
}

World build_pallet(const SceneOptions& options) {
  World world{approached(options.seed)};
  Random random{options.seed};
  world.add(make_crate({approach_m + options.edge_m + 0.6, 0, 0}, {1.2, 1.6, options.rise_m}, random));
  return world;
}

}  // namespace stereogrid::scenes
