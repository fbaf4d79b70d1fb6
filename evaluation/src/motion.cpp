// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/motion.hpp"

#include <cmath>
#include <numbers>

#include "totals.hpp"
#include "truth_cells.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr std::int64_t settling_ns{1'000'000'000};
constexpr float occupied_from{0.5F};
constexpr float surely_there_above{0.6F};
constexpr float seems_to_move_above_mps{1.0F};

double direction_error_deg(Point2 truth, const Obstacle& found) {
  const double angle{
      std::atan2(truth.x * found.vy_mps - truth.y * found.vx_mps, truth.x * found.vx_mps + truth.y * found.vy_mps)};
  return std::abs(angle) * 180 / std::numbers::pi;
}

double share(double part, double whole) {
  return whole > 0 ? part / whole : MotionSummary::nothing;
}

void fill_hidden(const HiddenSurvival& hidden, MotionSummary& summary) {
  std::vector<double> hidden_s;
  std::vector<double> survived_s;
  std::size_t alive{0};
  for (const HiddenSurvival::Episode& episode : hidden.episodes()) {
    hidden_s.push_back(episode.hidden_s);
    survived_s.push_back(episode.survived_s);
    summary.hidden_frames += episode.frames;
    alive += episode.alive;
  }
  summary.hidden_episodes = hidden_s.size();
  summary.hidden_alive = share(static_cast<double>(alive), static_cast<double>(summary.hidden_frames));
  summary.hidden_s = quantile(hidden_s, 0.5);
  summary.survived_s = quantile(survived_s, 0.5);
}

}  // namespace

void MotionScores::add(const MotionFrame& frame) {
  if (!first_ns_) first_ns_ = frame.truth.stamp_ns;
  if (!frame.velocity_x.empty()) {
    const bool settled{frame.truth.stamp_ns >= *first_ns_ + settling_ns};
    if (settled) add_objects(frame);
    identities_.add(frame);
    add_cells(frame, settled);
  }
  ghosts_.add(frame);
  hidden_.add(frame);
}

void MotionScores::add_objects(const MotionFrame& frame) {
  const Pose2 vehicle_from_world{inverse(frame.truth.ego.world_from_vehicle)};
  const Pose2 turn{0, 0, vehicle_from_world.yaw_rad};
  for (const TruthObject& object : frame.truth.objects) {
    if (!is_moving(object) || object.pixels < matched_pixels_min) continue;
    const Point2 place{vehicle_from_world * Point2{object.world_from_object.x_m, object.world_from_object.y_m}};
    if (!is_inside(frame.grid, place)) continue;
    ++sightings_;
    const Obstacle* found{nearest_confirmed(frame.obstacles, place)};
    if (found == nullptr) continue;
    const Point2 velocity{turn * Point2{object.vx_mps, object.vy_mps}};
    speed_errors_mps_.push_back(
        std::abs(std::hypot(found->vx_mps, found->vy_mps) - std::hypot(velocity.x, velocity.y)));
    direction_errors_deg_.push_back(direction_error_deg(velocity, *found));
    velocity_errors_mps_.push_back(std::hypot(found->vx_mps - velocity.x, found->vy_mps - velocity.y));
  }
}

void MotionScores::add_cells(const MotionFrame& frame, bool settled) {
  const Pose2 turn{0, 0, -frame.truth.ego.world_from_vehicle.yaw_rad};
  for_shared_cells(frame, [&](int tx, int ty, int ix, int iy) {
    if (state_at(frame.truth, tx, ty) != TruthCell::seen_occupied) return;
    const Point2 velocity{turn * Point2{frame.truth.velocity_x(tx, ty), frame.truth.velocity_y(tx, ty)}};
    const float vx{frame.velocity_x(ix, iy)};
    const float vy{frame.velocity_y(ix, iy)};
    if (is_moving(frame.truth, tx, ty)) {
      if (!settled || frame.occupancy(ix, iy) < occupied_from) return;
      cell_velocity_errors_mps_.push_back(std::hypot(static_cast<double>(vx) - velocity.x,  //
                                                     static_cast<double>(vy) - velocity.y));
    } else if (velocity.x == 0 && velocity.y == 0) {
      ++static_cells_;
      if (frame.occupancy(ix, iy) > surely_there_above && std::hypot(vx, vy) > seems_to_move_above_mps) {
        ++static_moving_;
      }
    }
  });
}

MotionSummary MotionScores::summary() const {
  MotionSummary summary;
  summary.sightings = sightings_;
  summary.found = speed_errors_mps_.size();
  summary.speed_error_mps = quantile(speed_errors_mps_, 0.5);
  summary.direction_error_deg = quantile(direction_errors_deg_, 0.5);
  summary.velocity_error_mps = quantile(velocity_errors_mps_, 0.5);
  summary.id_switches = identities_.switches();
  summary.standing_obstacles = identities_.standing();
  summary.standing_with_speed =
      share(static_cast<double>(identities_.standing_with_speed()), static_cast<double>(identities_.standing()));
  summary.moving_cells = cell_velocity_errors_mps_.size();
  summary.cell_velocity_error_mps = quantile(cell_velocity_errors_mps_, 0.5);
  summary.static_cells = static_cells_;
  summary.static_moving = share(static_cast<double>(static_moving_), static_cast<double>(static_cells_));
  const std::vector<double> ghosts{ghosts_.seconds()};
  summary.left_cells = ghosts.size();
  summary.ghost_s = quantile(ghosts, 0.5);
  summary.gone_within_half_second = ghosts_.gone_within_half_second();
  fill_hidden(hidden_, summary);
  return summary;
}

}  // namespace stereogrid::evaluation
