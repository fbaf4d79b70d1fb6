// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"

#include <algorithm>
#include <cmath>

#include "layouts/terrain.hpp"
#include "world/height_field.hpp"

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

World flat_street(std::uint64_t seed) {
  World world;
  world.seed = seed;
  world.road = two_lanes(3.5, 0);
  return world;
}

}  // namespace

const std::vector<Layout>& layouts() {
  static const std::vector<Layout> all{{"around", 180, build_around},
                                       {"boxes", 10, build_boxes},
                                       {"corridor", 600, build_corridor},
                                       {"course", 100, build_course, 170},
                                       {"crossing", 40, build_crossing},
                                       {"empty", 20, build_empty},
                                       {"occlusion", 10, build_occlusion},
                                       {"pallet", 50, build_pallet},
                                       {"step", 50, build_step},
                                       {"street", 60, build_street},
                                       {"table", 50, build_table},
                                       {"terrain", 3, build_terrain},
                                       {"van", 30, build_van},
                                       {"wall", 5, build_wall}};
  return all;
}

Road two_lanes(double lane_width_m, double curvature_per_m) {
  constexpr double half_line_m{0.07};
  Road road;
  road.centre_left_m = lane_width_m / 2;
  road.curvature_per_m = curvature_per_m;
  road.paint.push_back({-1e4, 1e4, -half_line_m, half_line_m, 3, 7.5});
  for (const double edge : {-lane_width_m, lane_width_m}) {
    road.paint.push_back({-1e4, 1e4, edge - half_line_m, edge + half_line_m, 0, 0});
  }
  return road;
}

World build_around(const SceneOptions& options) {
  constexpr double radius_m{4};
  constexpr double wall_m{9};
  World world{flat_street(options.seed)};
  Random random{options.seed};
  Body walker{make_person({radius_m, 0, pi / 2}, random)};
  walker.motion.speed_mps = 1.5;
  walker.motion.curvature_per_m = 1 / radius_m;
  world.add(walker);
  for (const double side : {-1.0, 1.0}) {
    world.add(make_wall({side * (wall_m + 0.2), 0, pi / 2}, 2 * wall_m + 1, 2.5, random));
    world.add(make_wall({0, side * (wall_m + 0.2), 0}, 2 * wall_m + 1, 2.5, random));
    world.add(make_crate({side * 6.4, side * 2.4, 0.3}, {0.8, 0.6, 0.7}, random));
    world.add(make_crate({-side * 2.2, side * 6.2, 0}, {0.6, 0.8, 0.9}, random));
  }
  return world;
}

World build_boxes(const SceneOptions& options) {
  World world{flat_street(options.seed)};
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

World build_empty(const SceneOptions& options) {
  World world{flat_street(options.seed)};
  world.ego.speed_mps = 5;
  return world;
}

World build_occlusion(const SceneOptions& options) {
  World world{flat_street(options.seed)};
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

World build_van(const SceneOptions& options) {
  constexpr double following_mps{5};
  constexpr double van_speed_mps{4};
  constexpr double van_ahead_m{10.6};  // its middle; its back is 2.6 m nearer
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

World build_wall(const SceneOptions& options) {
  World world{flat_street(options.seed)};
  Random random{options.seed};
  world.add(make_wall({8.2, 0, pi / 2}, 40, 3, random));
  return world;
}

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
