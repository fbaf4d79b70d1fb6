// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "layouts/layouts.hpp"
#include "world/relief.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double approach_m{4};
constexpr double approach_mps{2};

double edge_of(const SceneOptions& options) {
  return options.edge_m > 0 ? options.edge_m : 2.5;
}

double rise_of(const SceneOptions& options) {
  return options.rise_m != 0 ? options.rise_m : 0.5;
}

// The vehicle drives for two seconds and stands before x = approach_m + edge_of(options) from then on.
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
  const int steps{std::max(options.steps, 1)};
  const double rise_m{rise_of(options) / steps};
  const double run_m{options.incline_deg < 90 ? std::abs(rise_m) * incline.cosine / incline.sine : 0};
  Polyline ground{{{approach_m + edge_of(options), 0}}};
  for (int step{0}; step < steps; ++step) {
    if (step > 0) ground.to(ground.last().at + tread_m, ground.last().value);
    ground.to(ground.last().at + run_m, ground.last().value + rise_m);
  }
  Relief relief;
  relief.add(ground);
  world.ground = relief.field();
  world.wheels = {0.2, 0.4, 0.2};
  return world;
}

World build_table(const SceneOptions& options) {
  constexpr double top_m{0.04};
  World world{approached(options.seed)};
  Random random{options.seed};
  const double middle_m{approach_m + edge_of(options) + 0.8};
  Body top{make_crate({middle_m, 0, 0}, {1.6, 2.4, top_m}, random)};
  world.add(top, rise_of(options) - top_m);
  for (const double x : {-0.7, 0.7}) {
    for (const double y : {-1.1, 1.1}) {
      world.add(make_crate({middle_m + x, y, 0}, {0.06, 0.06, rise_of(options) - top_m}, random));
    }
  }
  return world;
}

World build_pallet(const SceneOptions& options) {
  World world{approached(options.seed)};
  Random random{options.seed};
  world.add(make_crate({approach_m + edge_of(options) + 0.6, 0, 0}, {1.2, 1.6, rise_of(options)}, random));
  return world;
}

}  // namespace stereogrid::scenes
