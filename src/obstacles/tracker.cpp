// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "obstacles/tracking.hpp"

namespace stereogrid {
namespace {

// The grid's velocities say surely that a large thing stands; how fast a small one walks they say less well than its
// positions: the lattice is coarse, and what is newly covered counts as standing at first.
constexpr double standing_mps{0.5};
constexpr double large_m{1.5};
constexpr double large_sigma_mps{0.4};
constexpr double small_sigma_mps{1.0};
constexpr double velocity_sigma_mps{2.0};
/// In association, a difference of 1 m/s counts like so many metres.
constexpr double velocity_weight_s{0.4};
/// Squared difference of two velocities in variances beyond which it is not the same thing.
constexpr double another_thing{16};
constexpr double unknown_velocity_mps{3};
constexpr double free_occupancy{0.2};
constexpr double gone_s{0.25};
constexpr double moving_mps{1};
/// Evidence of motion: a measured velocity says less than its covariance would have it, several frames say more.
constexpr double evidence_max{6};
constexpr double evidence_of_frame{1.5};
constexpr double surely_moving{3};
constexpr double highest_mover_m{4.2};
constexpr double replaced_within_m{0.3};
constexpr double hidden_by_m{0.3};
/// What is seen so large is no chance match.
constexpr int surely_seen_px{300};

Covariance2 turned(const Covariance2& p, double yaw_rad) {
  const double c{std::cos(yaw_rad)};
  const double s{std::sin(yaw_rad)};
  return {c * c * p.xx - 2 * c * s * p.xy + s * s * p.yy, c * s * (p.xx - p.yy) + (c * c - s * s) * p.xy,
          s * s * p.xx + 2 * c * s * p.xy + c * c * p.yy};
}

}  // namespace

double Bounds::gap_to(const Bounds& other, Point2 moved) const {
  const double x{std::max(other.least.x - (most.x + moved.x), least.x + moved.x - other.most.x)};
  const double y{std::max(other.least.y - (most.y + moved.y), least.y + moved.y - other.most.y)};
  return std::hypot(std::max(x, 0.0), std::max(y, 0.0));
}

void Tracker::Axis::predict(double dt_s, double acceleration_mps2) {
  const double q{acceleration_mps2 * acceleration_mps2};
  position += velocity * dt_s;
  covariance[0] += 2 * dt_s * covariance[1] + dt_s * dt_s * covariance[2] + q * dt_s * dt_s * dt_s * dt_s / 4;
  covariance[1] += dt_s * covariance[2] + q * dt_s * dt_s * dt_s / 2;
  covariance[2] += q * dt_s * dt_s;
}

void Tracker::Axis::update_position(double measured, double variance) {
  const double gain_p{covariance[0] / (covariance[0] + variance)};
  const double gain_v{covariance[1] / (covariance[0] + variance)};
  const double innovation{measured - position};
  position += gain_p * innovation;
  velocity += gain_v * innovation;
  covariance[2] -= gain_v * covariance[1];
  covariance[1] -= gain_v * covariance[0];
  covariance[0] -= gain_p * covariance[0];
}

void Tracker::Axis::update_velocity(double measured, double variance) {
  const double gain_p{covariance[1] / (covariance[2] + variance)};
  const double gain_v{covariance[2] / (covariance[2] + variance)};
  const double innovation{measured - velocity};
  position += gain_p * innovation;
  velocity += gain_v * innovation;
  covariance[0] -= gain_p * covariance[1];
  covariance[1] -= gain_p * covariance[2];
  covariance[2] -= gain_v * covariance[2];
}

Tracker::Tracker(const TrackingConfig& config, const Rig& level_rig) : config_{config}, rig_{level_rig} {
  constexpr std::size_t pairs_of_a_thing{4};
  tracks_.reserve(things_reserved);
  pairs_.reserve(pairs_of_a_thing * things_reserved);
  is_track_taken_.reserve(things_reserved);
  is_cluster_taken_.reserve(things_reserved);
}

void Tracker::update(const GridLayers& world, const std::vector<Cluster>& clusters, const Pose2& world_from_vehicle,
                     double dt_s) {
  for (Track& track : tracks_) {
    // while it is not seen, only what points have shown to move goes on
    if (track.unseen_s > 0 && track.moving < evidence_of_frame) track.x.velocity = track.y.velocity = 0;
    const Point2 before{track.x.position, track.y.position};
    track.x.predict(dt_s, config_.acceleration_mps2);
    track.y.predict(dt_s, config_.acceleration_mps2);
    track.moved.x += track.x.position - before.x;
    track.moved.y += track.y.position - before.y;
    track.age_s += dt_s;
    track.unseen_s += dt_s;
  }
  associate(clusters);
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  std::erase_if(tracks_, [&](const Track& track) {
    return track.unseen_s > 0 && (is_over(track, clusters, world, vehicle_from_world) || is_replaced(track, clusters));
  });
}

// In its velocity, and surely.
bool Tracker::differs(const Cluster& cluster, const Track& track) {
  const Symmetric2& measured{cluster.velocity_covariance};
  const Symmetric2 both{measured.xx + track.x.covariance[2], measured.xy, measured.yy + track.y.covariance[2]};
  const Point2 faster{cluster.velocity.x - track.x.velocity, cluster.velocity.y - track.y.velocity};
  return squared(inverted(both), faster) > another_thing;
}

// Nearest first; of those equally far, in the order of tracks and clusters.
void Tracker::find_pairs(const std::vector<Cluster>& clusters) {
  pairs_.clear();
  for (std::size_t t{0}; t < tracks_.size(); ++t) {
    for (std::size_t c{0}; c < clusters.size(); ++c) {
      const Point2 away{clusters[c].centre.x - tracks_[t].x.position, clusters[c].centre.y - tracks_[t].y.position};
      const double faster_mps{
          std::hypot(clusters[c].velocity.x - tracks_[t].x.velocity, clusters[c].velocity.y - tracks_[t].y.velocity)};
      const bool is_measured{clusters[c].has_measured_velocity()};
      if (is_measured && differs(clusters[c], tracks_[t])) continue;
      const double gap_m{tracks_[t].shape.bounds.gap_to(clusters[c].bounds, tracks_[t].moved)};
      const double away_m{std::hypot(away.x, away.y)};
      if (gap_m > config_.gate_m ||
          away_m > config_.gate_m + 0.5 * std::max(tracks_[t].shape.length_m, clusters[c].length_m)) {
        continue;
      }
      pairs_.push_back({(gap_m + away_m) / 2 + (is_measured ? velocity_weight_s * faster_mps : 0), t, c});
    }
  }
  // not stable_sort, which allocates
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.track, a.cluster) < std::tie(b.distance, b.track, b.cluster);
  });
}

void Tracker::associate(const std::vector<Cluster>& clusters) {
  find_pairs(clusters);
  is_track_taken_.assign(tracks_.size(), 0);
  is_cluster_taken_.assign(clusters.size(), 0);
  for (const Pair& pair : pairs_) {
    if (is_track_taken_[pair.track] != 0 || is_cluster_taken_[pair.cluster] != 0) continue;
    is_track_taken_[pair.track] = is_cluster_taken_[pair.cluster] = 1;
    correct(tracks_[pair.track], clusters[pair.cluster]);
  }
  for (std::size_t c{0}; c < clusters.size(); ++c) {
    if (is_cluster_taken_[c] == 0) begin_track(clusters[c]);
  }
}

// Of one frame. The grid alone tells motion later, and less surely, than points that have been followed.
double Tracker::evidence_of_motion(const Cluster& cluster) {
  if (cluster.kind == ObstacleKind::extended) return -evidence_of_frame;
  if (cluster.height_m > highest_mover_m) return 0;  // with a tree above it
  if (cluster.has_measured_velocity()) {
    const double square{squared(inverted(cluster.velocity_covariance), cluster.velocity)};
    return std::clamp(square / 2 - 2, -evidence_of_frame, evidence_of_frame);
  }
  return std::hypot(cluster.velocity.x, cluster.velocity.y) > moving_mps ? evidence_of_frame / 4
                                                                         : -evidence_of_frame / 4;
}

void Tracker::correct(Track& track, const Cluster& cluster) const {
  // where the outline of a large thing changes with what is seen of it, its centre says little about its motion
  const double change{std::abs(cluster.length_m - track.shape.length_m) +
                      std::abs(cluster.width_m - track.shape.width_m)};
  const double position_sigma{0.15 + 0.05 * cluster.length_m + 0.5 * change};
  const bool is_large{cluster.length_m > large_m};
  const bool stands{std::hypot(cluster.velocity.x, cluster.velocity.y) < standing_mps};
  const double standing_sigma_mps{is_large ? large_sigma_mps : small_sigma_mps};
  const double of_cells_mps{stands ? standing_sigma_mps : velocity_sigma_mps};
  const Symmetric2 velocity_covariance{cluster.has_measured_velocity()
                                           ? cluster.velocity_covariance
                                           : Symmetric2{of_cells_mps * of_cells_mps, 0, of_cells_mps * of_cells_mps}};
  track.x.update_position(cluster.centre.x, position_sigma * position_sigma);
  track.y.update_position(cluster.centre.y, position_sigma * position_sigma);
  track.x.update_velocity(cluster.velocity.x, velocity_covariance.xx);
  track.y.update_velocity(cluster.velocity.y, velocity_covariance.yy);
  track.moving = std::clamp(track.moving + evidence_of_motion(cluster), -evidence_max, evidence_max);
  track.shape = cluster;
  track.moved = {};
  track.unseen_s = 0;
  ++track.sightings;
  track.pixels += cluster.pixels;
}

void Tracker::begin_track(const Cluster& cluster) {
  const double position_variance{0.3 * 0.3};
  constexpr double unknown{unknown_velocity_mps * unknown_velocity_mps};
  const Symmetric2 velocity_covariance{cluster.has_measured_velocity() ? cluster.velocity_covariance
                                                                       : Symmetric2{unknown, 0, unknown}};
  Track track;
  track.id = next_id_++;
  track.x = {cluster.centre.x, cluster.velocity.x, {position_variance, 0, velocity_covariance.xx}};
  track.y = {cluster.centre.y, cluster.velocity.y, {position_variance, 0, velocity_covariance.yy}};
  track.shape = cluster;
  track.sightings = 1;
  track.pixels = cluster.pixels;
  tracks_.push_back(track);
}

bool Tracker::is_confirmed(const Track& track) const {
  return track.sightings >= config_.confirm_frames || track.pixels >= surely_seen_px;
}

bool Tracker::is_over(const Track& track, const std::vector<Cluster>& clusters, const GridLayers& world,
                      const Pose2& vehicle_from_world) const {
  // twice as long as it was seen: fragments of a frame end with it
  const double seen_s{track.age_s - track.unseen_s};
  if (track.unseen_s > std::min(config_.coast_s, 2 * seen_s) || !is_confirmed(track)) return true;
  const Point2 at{vehicle_from_world * Point2{track.x.position, track.y.position}};
  const double column{rig_.centre_u_px - rig_.focal_px * at.y / at.x};
  if (!(at.x > 0 && column > 0 && column < rig_.width_px)) return true;  // nobody will see whether it is still there
  if (track.unseen_s > gone_s && track.moving < surely_moving && !is_hidden(at, clusters, vehicle_from_world))
    return true;
  const GridGeometry& grid{world.geometry};
  const auto cell = grid.cell_at({track.x.position, track.y.position});
  if (!cell) return true;
  return track.unseen_s > gone_s && world.occupancy(cell->ix, cell->iy) < free_occupancy &&
         world.age_s(cell->ix, cell->iy) == 0;
}

// Is something seen in front of it?
bool Tracker::is_hidden(Point2 at, const std::vector<Cluster>& clusters, const Pose2& vehicle_from_world) {
  const double slope{at.y / at.x};
  return std::any_of(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
    constexpr double far{std::numeric_limits<double>::max()};
    double least{far};
    double most{-far};
    double nearest{far};
    for (const Point2& point : cluster.outline) {
      const Point2 here{vehicle_from_world * point};
      if (!(here.x > 0)) continue;
      least = std::min(least, here.y / here.x);
      most = std::max(most, here.y / here.x);
      nearest = std::min(nearest, here.x);
    }
    return least < slope && slope < most && nearest < at.x - hidden_by_m;
  });
}

// Half of what stands there or more is now seen as a part of another thing, or of several.
bool Tracker::is_replaced(const Track& track, const std::vector<Cluster>& clusters) {
  if (track.moving >= surely_moving) return false;  // it may be hidden behind that
  std::size_t taken{0};
  for (const Point2& point : track.shape.outline) {
    const Point2 at{point.x + track.moved.x, point.y + track.moved.y};
    taken += std::any_of(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
      return cluster.kind == ObstacleKind::thing && cluster.bounds.gap_to({at, at}, {}) < replaced_within_m;
    });
  }
  return 2 * taken >= track.shape.outline.size();
}

void Tracker::report(const Pose2& world_from_vehicle, std::vector<Obstacle>& obstacles) const {
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  const Pose2 turn{0, 0, vehicle_from_world.yaw_rad};
  obstacles.clear();
  for (const Track& track : tracks_) {
    const bool moves{track.moving >= surely_moving};
    // what is not said to move stands where it is seen: its state may still believe in motion
    const Point2 at{vehicle_from_world * (moves ? Point2{track.x.position, track.y.position} : track.shape.centre)};
    const Point2 v{moves ? turn * Point2{track.x.velocity, track.y.velocity} : Point2{}};
    obstacles.push_back({track.id, at.x, at.y, v.x, v.y, track.shape.length_m, track.shape.width_m,
                         std::remainder(track.shape.yaw_rad + vehicle_from_world.yaw_rad, 2 * M_PI),
                         track.shape.occupancy, track.age_s, is_confirmed(track), std::hypot(v.x, v.y) > moving_mps,
                         track.unseen_s > 0, track.unseen_s,
                         turned({track.x.covariance[0], 0, track.y.covariance[0]}, turn.yaw_rad),
                         turned({track.x.covariance[2], 0, track.y.covariance[2]}, turn.yaw_rad), track.shape.kind,
                         track.shape.height_m, track.shape.outline});
    for (Point2& point : obstacles.back().outline) {
      point = vehicle_from_world * (moves ? Point2{point.x + track.moved.x, point.y + track.moved.y} : point);
    }
  }
}

}  // namespace stereogrid
