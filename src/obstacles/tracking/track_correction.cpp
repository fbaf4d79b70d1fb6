// SPDX-License-Identifier: Apache-2.0
//
// Correction of a track by its cluster.
#include <algorithm>
#include <cmath>
#include <limits>

#include "obstacles/tracking/tracking.hpp"

namespace stereogrid {
namespace {

// Limit for the grid's velocities. They detect static large objects reliably. For the speed of small ones positions are
// more accurate: the lattice is coarse, and new cells are static at first.
constexpr double standing_mps{0.5};
constexpr double large_m{1.5};
constexpr double large_sigma_mps{0.4};
constexpr double small_sigma_mps{1.0};
constexpr double velocity_sigma_mps{2.0};
constexpr double evidence_max{6};
constexpr double evidence_least{-3};
constexpr double highest_mover_m{4.2};
constexpr double slow_mps{2};
/// Added to what a side errs by: from frame to frame its errors are alike.
constexpr double place_sigma_m{0.2};
/// Share of a change of size: with other visible parts, the sides may be others, too.
constexpr double change_share{0.5};
/// Standard deviation of the longer side of static things: fitted to rendered sequences.
constexpr double yaw_step_rad{0.15};
constexpr double other_axes_rad{0.3};

// Weight of motion: visible parts of a cut-off cluster change from frame to frame, which resembles slow motion.
double trust_in_motion(const Cluster& cluster) {
  const bool is_cut{cluster.is_cut_left || cluster.is_cut_right};
  return is_cut && std::hypot(cluster.velocity.x, cluster.velocity.y) < slow_mps ? 0.5 : 1;
}

// Standard deviation of the centre of a boundary's visible part: large if that changes.
double large_sigma_of(const Cluster& cluster, const Cluster& before) {
  const double change_m{std::abs(cluster.length_m - before.length_m) + std::abs(cluster.width_m - before.width_m)};
  return 0.15 + 0.05 * cluster.length_m + 0.5 * change_m;
}

// Standard deviation of the longer side's heading of a static thing. Large if both sides are similar.
double yaw_sigma_of(const Cluster& cluster, const BoxView& view) {
  constexpr double longer{1.4};
  if (cluster.length_m < longer * cluster.width_m) return std::numeric_limits<double>::infinity();
  return std::hypot(yaw_step_rad, 2 * view.face_sigma_m() / cluster.length_m);
}

}  // namespace

// Evidence of one frame. Without tracked features, the grid indicates motion later and less reliably.
double Tracker::evidence_of_motion(const Cluster& cluster) {
  if (cluster.kind != ObstacleKind::object) return -evidence_of_frame;
  if (cluster.height_m > highest_mover_m) return 0;  // with a tree above it
  if (cluster.has_measured_velocity()) {
    const double square{squared(inverted(cluster.velocity_covariance), cluster.velocity)};
    return std::clamp(square / 2 - 2, -evidence_of_frame, trust_in_motion(cluster) * evidence_of_frame);
  }
  return std::hypot(cluster.velocity.x, cluster.velocity.y) > moving_mps ? evidence_of_frame / 4
                                                                         : -evidence_of_frame / 4;
}

// Heading of the box: along the velocity for dynamic things, else as first seen.
double Tracker::axes_of(const Track& track) {
  const Point2 velocity{track.motion.velocity()};
  const bool moves{track.moving >= surely_moving && std::hypot(velocity.x, velocity.y) > moving_mps};
  return moves ? std::atan2(velocity.y, velocity.x) : track.box.yaw_rad;
}

// Uses the visible sides: parts that come into view behind them are no motion.
void Tracker::correct_place(Track& track, const Cluster& cluster, const Pose2& camera) const {
  const double yaw_rad{axes_of(track)};
  const BoxView view{cluster, yaw_rad, camera, rig_of(cluster)};
  if (cluster.kind != ObstacleKind::object || track.shape.kind != ObstacleKind::object) {
    const double sigma{large_sigma_of(cluster, track.shape)};
    track.motion.measure_place({1, 0}, cluster.centre.x, sigma * sigma);
    track.motion.measure_place({0, 1}, cluster.centre.y, sigma * sigma);
    track.box.begin(view, yaw_rad, track.motion.place());
    return;
  }
  if (std::abs(std::remainder(yaw_rad - track.box.yaw_rad, 2 * M_PI)) > other_axes_rad) {
    track.box.begin(view, yaw_rad, track.motion.place());
    return;
  }
  track.box.yaw_rad = yaw_rad;
  for (std::size_t axis{0}; axis < 2; ++axis) {
    double place_m{0};
    double sigma_m{0};
    int sides{0};
    for (std::size_t end{0}; end < 2; ++end) {
      const BoxSide& side{view.sides[axis][end]};
      if (!side.is_near || !side.is_seen()) continue;
      place_m += side.at_m - track.box.reach_m[axis][end];
      sigma_m += side.sigma_m;
      ++sides;
    }
    if (sides == 0) continue;
    const double change_m{std::abs(view.sides[axis][1].at_m - view.sides[axis][0].at_m - track.box.extent_m(axis))};
    const double sigma{place_sigma_m + sigma_m / sides + change_share * change_m};
    track.motion.measure_place(view.axes[axis], place_m / sides, sigma * sigma);
  }
  track.box.update(view, track.motion.place());
}

void Tracker::set_shape(Track& track, const Cluster& cluster, const Pose2& camera) const {
  track.shape = cluster;
  const BoxView view{cluster, cluster.yaw_rad, camera, rig_of(cluster)};
  constexpr double unknown{std::numeric_limits<double>::infinity()};
  track.yaw_sigma_rad = cluster.kind == ObstacleKind::object ? yaw_sigma_of(cluster, view) : unknown;
}

void Tracker::correct(Track& track, const Cluster& cluster, const Pose2& camera) const {
  const bool is_large{cluster.length_m > large_m};
  const bool stands{std::hypot(cluster.velocity.x, cluster.velocity.y) < standing_mps};
  const double standing_sigma_mps{is_large ? large_sigma_mps : small_sigma_mps};
  const double of_cells_mps{stands ? standing_sigma_mps : velocity_sigma_mps};
  correct_place(track, cluster, camera);
  track.motion.measure_velocity(cluster.velocity,
                                cluster.has_measured_velocity()
                                    ? cluster.velocity_covariance
                                    : Symmetric2{of_cells_mps * of_cells_mps, 0, of_cells_mps * of_cells_mps});
  track.moving = std::clamp(track.moving + evidence_of_motion(cluster), evidence_least, evidence_max);
  set_shape(track, cluster, camera);
  track.moved = {};
  track.unseen_s = 0;
  if (cluster.is_sure) ++track.sightings;
  track.pixels += cluster.pixels;
}

}  // namespace stereogrid
