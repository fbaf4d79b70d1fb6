// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"
#include "layouts/terrain.hpp"
#include "world/props.hpp"

namespace stereogrid::scenes {

World build_corridor(const SceneOptions& options) {
  constexpr double half_width_m{1.4};
  constexpr double end_m{16};
  Site site{options};
  Random& random{site.random};
  const auto side = [&random] { return random.between(-1, 1) < 0 ? -1.0 : 1.0; };
  Feature ramp;
  ramp.at_m = 9;
  ramp.slope = 0.1;
  ramp.span_m = random.between(0.6, 1.2);
  build_ramp(site, ramp);
  const double box_side{side()};
  site.put(make_crate({random.between(2.6, 3.4), box_side * random.between(0.7, 0.95), 0},
                      {random.between(0.4, 0.6), random.between(0.4, 0.6), random.between(0.25, 0.5)}, random));
  Body walker{make_person({random.between(8, 8.8), -box_side * random.between(0.75, 0.95), pi}, random)};
  walker.motion.speed_mps = random.between(0.5, 0.8);
  site.put(walker);
  for (const double left : {-1.0, 1.0}) {
    site.put(make_wall({end_m / 2 - 1, left * (half_width_m + 0.2), 0}, end_m + 2, 1.2, random));
  }
  site.put(make_wall({end_m, 0, pi / 2}, 2 * half_width_m, 1.2, random));
  Feature stairs;
  stairs.at_m = random.between(11.8, 12.4);
  stairs.rise_m = -0.12;
  stairs.span_m = 0.25;
  stairs.steps = 4;
  stairs.length_m = end_m - stairs.at_m;
  (side() < 0 ? stairs.left_m : stairs.right_m) = 0;
  build_stairs(site, stairs);
  site.world.zones.push_back(
      {"stairs", true, {stairs.at_m, stairs.right_m}, {stairs.at_m + stairs.length_m, stairs.left_m}});
  return site.finished();
}

}  // namespace stereogrid::scenes
