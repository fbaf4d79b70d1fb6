// SPDX-License-Identifier: Apache-2.0
//
// Tracks as obstacles.
#include <cmath>

#include "obstacles/tracking/tracking.hpp"

namespace stereogrid {
namespace {

Covariance2 turned(const Symmetric2& p, double yaw_rad) {
  const double c{std::cos(yaw_rad)};
  const double s{std::sin(yaw_rad)};
  return {c * c * p.xx - 2 * c * s * p.xy + s * s * p.yy, c * s * (p.xx - p.yy) + (c * c - s * s) * p.xy,
          s * s * p.xx + 2 * c * s * p.xy + c * c * p.yy};
}

// Standard deviation of the velocity's direction.
double heading_sigma_of(const MotionState& motion) {
  const Point2 velocity{motion.velocity()};
  const double square{velocity.x * velocity.x + velocity.y * velocity.y};
  return std::sqrt(squared(motion.velocity_covariance(), {-velocity.y, velocity.x})) / square;
}

Bounds bounds_of(const GridGeometry& grid) {
  return {{grid.x_min_m, grid.y_min_m},
          {grid.x_min_m + grid.nx * grid.cell_size_m, grid.y_min_m + grid.ny * grid.cell_size_m}};
}

}  // namespace

void Tracker::report(const Pose2& world_from_vehicle, const GridGeometry& vehicle_grid,
                     std::vector<Obstacle>& obstacles) const {
  const Bounds grid{bounds_of(vehicle_grid)};
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  obstacles.clear();
  for (const Track& track : tracks_) {
    if (track.is_merged) continue;
    Obstacle obstacle{obstacle_of(track, vehicle_from_world)};
    obstacle.confirmed = is_certain(track) && bounds_of(obstacle.outline).gap_to(grid, {}) == 0;
    obstacles.push_back(obstacle);
  }
}

// Unobserved tracks need evidence from more frames.
bool Tracker::seems_to_move(const Track& track) {
  return track.moving >= surely_moving + (track.unseen_s > 0 ? evidence_of_frame : 0);
}

Obstacle Tracker::obstacle_of(const Track& track, const Pose2& vehicle_from_world) const {
  const Pose2 turn{0, 0, vehicle_from_world.yaw_rad};
  const bool moves{seems_to_move(track)};
  const Point2 velocity{moves ? turn * track.motion.velocity() : Point2{}};
  // static obstacles stay at their observed place: their state may still contain motion
  const Point2 at{vehicle_from_world * (moves ? track.middle() : track.shape.centre)};
  const double yaw_rad{moves ? track.box.yaw_rad : track.shape.yaw_rad};
  Obstacle obstacle;
  obstacle.id = track.id;
  obstacle.x_m = at.x;
  obstacle.y_m = at.y;
  obstacle.vx_mps = velocity.x;
  obstacle.vy_mps = velocity.y;
  obstacle.length_m = moves ? track.box.extent_m(0) : track.shape.length_m;
  obstacle.width_m = moves ? track.box.extent_m(1) : track.shape.width_m;
  obstacle.yaw_rad = std::remainder(yaw_rad + vehicle_from_world.yaw_rad, 2 * M_PI);
  obstacle.occupancy = track.shape.occupancy;
  obstacle.age_s = track.age_s;
  obstacle.moving = std::hypot(velocity.x, velocity.y) > moving_mps;
  obstacle.coasting = track.unseen_s > 0;
  obstacle.unseen_s = track.unseen_s;
  obstacle.position_covariance = turned(track.motion.place_covariance(), turn.yaw_rad);
  obstacle.velocity_covariance = turned(track.motion.velocity_covariance(), turn.yaw_rad);
  obstacle.yaw_rate_radps = obstacle.moving ? track.motion.yaw_rate_radps() : 0;
  // the smallest box around a static thing often covers a part only: its size is unknown
  if (moves) {
    obstacle.length_sigma_m = track.box.extent_sigma_m(0);
    obstacle.width_sigma_m = track.box.extent_sigma_m(1);
  }
  obstacle.yaw_sigma_rad = obstacle.moving ? heading_sigma_of(track.motion) : track.yaw_sigma_rad;
  obstacle.kind = track.shape.kind;
  obstacle.height_m = track.shape.height_m;
  obstacle.outline = track.shape.fitted.empty() ? track.shape.outline : track.shape.fitted;
  for (Point2& point : obstacle.outline) {
    point = vehicle_from_world * (moves ? Point2{point.x + track.moved.x, point.y + track.moved.y} : point);
  }
  return obstacle;
}

}  // namespace stereogrid
