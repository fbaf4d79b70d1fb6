// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "layouts/layouts.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double lane_m{3.3};
constexpr double kerb_m{5.5};      ///< centre line to kerb
constexpr double pavement_m{2.6};  ///< width
constexpr double ego_speed_mps{8};
constexpr double yaw_rate_radps{0.05};
constexpr double first_m{-14};
constexpr double screen_m{26.6};  ///< along: the parked car that hides a walker

/// Places along the street's centre line.
struct Street {
  double curvature_per_m{0};
  double length_m{0};

  [[nodiscard]] Pose2 at(double along_m, double left_m) const {
    return along_arc({0, lane_m / 2, 0}, curvature_per_m, along_m, left_m);
  }
  [[nodiscard]] Pose2 facing(double along_m, double left_m, double turn_rad) const {
    const Pose2 pose{at(along_m, left_m)};
    return {pose.x_m, pose.y_m, pose.yaw_rad + turn_rad};
  }
};

void add_pavements(World& world, const Street& street, double side) {
  constexpr double piece_m{4};
  for (double s{first_m}; s < street.length_m; s += piece_m) {
    world.add(make_pavement(street.at(s, side * (kerb_m + pavement_m / 2)), piece_m * 1.05, pavement_m));
  }
}

void add_houses(World& world, const Street& street, double side, Random& random) {
  double s{first_m};
  while (s < street.length_m) {
    const double length{random.between(8, 13)};
    const double height{random.between(6, 10)};
    const double left{side * (kerb_m + pavement_m + 3.6 + random.between(0, 0.5))};
    world.add(make_house(street.at(s + length / 2, left), length * 1.02, 7, height, random));
    s += length + (random.between(0, 1) < 0.25 ? 3.0 : 0.0);
  }
}

/// Parked vehicles with a gap from which a person steps out.
void add_parked(World& world, const Street& street, double side, Random& random) {
  for (double s{-8}; s < street.length_m; s += random.between(5.6, 7.4)) {
    const double chance{random.between(0, 1)};
    const Pose2 pose{street.facing(s, side * (kerb_m - 1.1), side > 0 ? pi : 0.0)};
    const bool kept_clear{side < 0 && (std::abs(s - screen_m) < 5.6 || std::abs(s - 60) < 3.2)};
    if (kept_clear || chance < 0.15) continue;
    world.add(chance > 0.92 ? make_van(pose, random) : make_car(pose, random));
  }
}

void add_furniture(World& world, const Street& street, double side, Random& random) {
  for (double s{-6 + 2 * side}; s < street.length_m; s += random.between(9, 13)) {
    const Pose2 pose{street.at(s, side * (kerb_m + 0.5))};
    world.add(random.between(0, 1) < 0.5 ? make_tree(pose, random) : make_pole(pose, 4.5, random), pavement_height_m);
  }
}

Body walking(Body person, double begin_s, double end_s) {
  person.motion.speed_mps = 1.5;
  person.motion.begin_s = begin_s;
  person.motion.end_s = end_s;
  return person;
}

void add_movers(World& world, const Street& street, Random& random) {
  Body oncoming{make_car(street.facing(55, lane_m / 2, pi), random)};
  oncoming.motion.speed_mps = 8;
  oncoming.motion.curvature_per_m = -1 / (1 / street.curvature_per_m - lane_m / 2);
  world.add(oncoming);
  // Steps out from behind the parked car and stops short of the lane; the other one crosses farther on.
  world.add(walking(make_person(street.facing(30, -5.2, pi / 2), random), 0.8, 2.1));
  world.add(make_car(street.at(screen_m, -(kerb_m - 1.1)), random));
  world.add(walking(make_person(street.facing(60, -5.2, pi / 2), random), 2.5, 10));
}

void add_crossing(World& world, Random& random) {
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

World build_street(const SceneOptions& options) {
  const double duration_s{options.frames / options.rate_hz};
  World world;
  world.seed = options.seed;
  world.ego.speed_mps = ego_speed_mps;
  world.ego.curvature_per_m = yaw_rate_radps / ego_speed_mps;
  const Street street{1 / (1 / world.ego.curvature_per_m - lane_m / 2),
                      std::max(130.0, ego_speed_mps * duration_s + 80)};
  world.road = two_lanes(lane_m, street.curvature_per_m);
  Random movers{scramble(options.seed)};
  add_movers(world, street, movers);
  for (const double side : {-1.0, 1.0}) {
    // A sequence of its own for each row, so that a longer street begins like a shorter one.
    const std::uint64_t row{options.seed * 8 + (side > 0 ? 4 : 0)};
    Random parked{row + 1};
    Random furniture{row + 2};
    Random houses{row + 3};
    add_parked(world, street, side, parked);
    add_furniture(world, street, side, furniture);
    add_houses(world, street, side, houses);
    add_pavements(world, street, side);
  }
  return world;
}

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
  add_crossing(world, random);
  return world;
}

}  // namespace stereogrid::scenes
