// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "stereogrid/evaluation/motion.hpp"
#include "truth_cells.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double near_a_mover_m{3};
constexpr double has_speed_above_mps{1};

double distance(const Obstacle& obstacle, Point2 place) {
  return std::hypot(obstacle.x_m - place.x, obstacle.y_m - place.y);
}

/// The one of that id where it still is at the place, else the nearest; none: nullptr.
const Obstacle* obstacle_at(std::span<const Obstacle> obstacles, Point2 place, const std::int64_t* id_before) {
  const Obstacle* best{nearest_confirmed(obstacles, place)};
  for (const Obstacle& obstacle : obstacles) {
    if (id_before != nullptr && obstacle.id == *id_before && obstacle.confirmed &&
        distance(obstacle, place) <= match_within_m) {
      best = &obstacle;
    }
  }
  return best;
}

}  // namespace

void Identities::add(const MotionFrame& frame) {
  const Pose2 vehicle_from_world{inverse(frame.truth.ego.world_from_vehicle)};
  std::vector<Point2> movers;
  for (const TruthObject& object : frame.truth.objects) {
    if (!is_moving(object)) continue;
    const Point2 place{vehicle_from_world * Point2{object.world_from_object.x_m, object.world_from_object.y_m}};
    movers.push_back(place);
    if (object.pixels < matched_pixels_min || !is_inside(frame.grid, place)) continue;
    const auto before{id_of_object_.find(object.id)};
    const Obstacle* found{
        obstacle_at(frame.obstacles, place, before == id_of_object_.end() ? nullptr : &before->second)};
    if (found == nullptr) continue;
    if (before != id_of_object_.end() && before->second != found->id) ++switches_;
    id_of_object_[object.id] = found->id;
  }
  for (const Obstacle& obstacle : frame.obstacles) {
    const auto at_mover = [&](Point2 mover) { return distance(obstacle, mover) <= near_a_mover_m; };
    if (!obstacle.confirmed || std::ranges::any_of(movers, at_mover)) continue;
    ++standing_;
    if (std::hypot(obstacle.vx_mps, obstacle.vy_mps) > has_speed_above_mps) ++standing_with_speed_;
  }
}

}  // namespace stereogrid::evaluation
