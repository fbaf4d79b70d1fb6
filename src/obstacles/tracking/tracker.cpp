// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "geometry/composed.hpp"
#include "obstacles/tracking/tracking.hpp"

namespace stereogrid {
namespace {

/// Maximum distance between a cluster and the prediction of its track.
constexpr double gate_m{1.5};
/// Process noise of the constant-velocity model.
constexpr double acceleration_mps2{4};
/// In association, metres per difference of 1 m/s.
constexpr double velocity_weight_s{0.4};
/// … metres for a cluster without features that may be dynamic, …
constexpr double unmeasured_mover_m{0.3};
/// … and a metre of difference in height, as far as it goes: a kerb is not the cyclist before it.
constexpr double height_weight{0.4};
constexpr double differing_height_m{2};
/// Squared difference of two velocities in variances beyond which it is not the same thing.
constexpr double another_thing{16};
constexpr double unknown_velocity_mps{3};
/// Maximum evidence of the filter at a thing's first observation.
constexpr double most_before{1.5};
/// Maximum velocity difference of overlapping parts of one thing.
constexpr double alike_mps{1};
constexpr double free_occupancy{0.2};
constexpr double gone_s{0.25};
constexpr double replaced_within_m{0.3};
/// Minimum time of separate observation by which a thing differs from a fragment, …
constexpr double known_s{1};
/// … and parts from what it merged with about where it was, about as long.
constexpr double parted_within_m{0.7};
constexpr double hidden_by_m{0.3};
/// Size from which a match is not by chance.
constexpr int surely_seen_px{300};

// Initial evidence of motion from the filter's cells: log odds. Unknown cells do not count.
double moving_before(const Cluster& cluster) {
  constexpr double open{0.05};  // prior of a cell's share that the filter has not observed
  if (cluster.kind != ObstacleKind::object) return 0;
  return std::clamp(std::log((cluster.moving + open) / (1 - cluster.moving + open)), 0.0, most_before);
}

// `at`: vehicle frame.
bool is_in_view_of(const Rig& rig, Point2 at) {
  const Point2 place{inverse(camera_place(rig)) * at};
  const double column{rig.cx_px - rig.focal_px * place.y / place.x};
  return place.x > 0 && column > 0 && column < rig.width_px;
}

}  // namespace

double Bounds::gap_to(const Bounds& other, Point2 moved) const {
  const double x{std::max(other.least.x - (most.x + moved.x), least.x + moved.x - other.most.x)};
  const double y{std::max(other.least.y - (most.y + moved.y), least.y + moved.y - other.most.y)};
  return x > 0 && y > 0 ? std::hypot(x, y) : std::max({x, y, 0.0});
}

Point2 Tracker::Track::middle() const {
  const Point2 place{motion.place()};
  const Point2 away{box.middle()};
  return {place.x + away.x, place.y + away.y};
}

Tracker::Tracker(const TrackingConfig& config, std::vector<Rig> level_rigs)
    : config_{config}, rigs_{std::move(level_rigs)} {
  constexpr std::size_t pairs_of_a_thing{4};
  tracks_.reserve(things_reserved);
  pairs_.reserve(pairs_of_a_thing * things_reserved);
  is_track_taken_.reserve(things_reserved);
  is_cluster_taken_.reserve(things_reserved);
}

void Tracker::update(const GridLayers& world, const std::vector<Cluster>& clusters, const Pose2& world_from_vehicle,
                     double dt_s, std::span<const std::int64_t> held, Cameras looking) {
  const auto is_held = [held](const Track& track) { return std::ranges::binary_search(held, track.id); };
  for (Track& track : tracks_) {
    // while unobserved, only motion shown by features continues
    if (track.unseen_s > 0 && (track.moving < evidence_of_frame || is_held(track))) track.motion.stand_still();
    const Point2 before{track.motion.place()};
    track.motion.predict(dt_s, acceleration_mps2);
    const Point2 after{track.motion.place()};
    track.moved = {track.moved.x + after.x - before.x, track.moved.y + after.y - before.y};
    track.age_s += dt_s;
    track.unseen_s += dt_s;
    track.is_remembered = false;
  }
  associate(clusters, world_from_vehicle);
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  for (Track& track : tracks_) {
    const bool is_missed{track.unseen_s > 0 && !is_held(track) && !track.is_remembered};
    track.is_merged = is_missed && (track.is_merged || is_replaced(track, clusters));
  }
  merge_movers();
  std::erase_if(tracks_, [&](const Track& track) {
    if (!(track.unseen_s > 0)) return false;
    const bool is_remembered{track.is_remembered && is_certain(track)};
    if (is_held(track) || is_remembered) return !is_in_view(vehicle_from_world * track.shape.centre);
    const Point2 at{vehicle_from_world * track.middle()};
    const bool is_looked_at{is_in_view(at, looking) || !is_in_view(at)};
    return is_expired(track, is_looked_at) ||
           (is_looked_at && !track.is_merged && is_over(track, clusters, world, vehicle_from_world));
  });
}

// In its velocity, and surely.
bool Tracker::differs(const Cluster& cluster, const Track& track) {
  const Symmetric2& measured{cluster.velocity_covariance};
  const Symmetric2 known{track.motion.velocity_covariance()};
  const Symmetric2 both{measured.xx + known.xx, measured.xy + known.xy, measured.yy + known.yy};
  const Point2 velocity{track.motion.velocity()};
  const Point2 faster{cluster.velocity.x - velocity.x, cluster.velocity.y - velocity.y};
  return squared(inverted(both), faster) > another_thing;
}

// In metres; none: it is another thing.
std::optional<double> Tracker::distance(const Track& track, const Cluster& cluster) const {
  if ((track.shape.kind == ObstacleKind::drop) != (cluster.kind == ObstacleKind::drop)) return std::nullopt;
  if (track.shape.is_low != cluster.is_low) return std::nullopt;
  const bool is_measured{cluster.has_measured_velocity()};
  if (is_measured && differs(cluster, track)) return std::nullopt;
  const double away_m{std::hypot(cluster.centre.x - track.shape.centre.x - track.moved.x,
                                 cluster.centre.y - track.shape.centre.y - track.moved.y)};
  const double gap_m{track.shape.bounds.gap_to(cluster.bounds, track.moved)};
  const double half_m{0.5 * std::max(track.shape.length_m, cluster.length_m)};
  if (gap_m > (cluster.is_seen ? gate_m : 0) || away_m > gate_m + half_m) return std::nullopt;
  const double longer_m{std::abs(cluster.length_m - track.shape.length_m)};
  if (track.is_merged && std::max(away_m, longer_m) > parted_within_m) return std::nullopt;
  const Point2 velocity{track.motion.velocity()};
  const double faster_mps{std::hypot(cluster.velocity.x - velocity.x, cluster.velocity.y - velocity.y)};
  const double unmeasured_m{track.moving >= surely_moving ? unmeasured_mover_m : 0};
  const double higher_m{std::min(std::abs(cluster.height_m - track.shape.height_m), differing_height_m)};
  return (gap_m + away_m) / 2 + (is_measured ? velocity_weight_s * faster_mps : unmeasured_m) +
         height_weight * higher_m;
}

// Nearest first; equal distances in the order of tracks and clusters. Former parts of another thing come last.
void Tracker::find_pairs(const std::vector<Cluster>& clusters) {
  pairs_.clear();
  for (std::size_t t{0}; t < tracks_.size(); ++t) {
    for (std::size_t c{0}; c < clusters.size(); ++c) {
      const std::optional<double> distance_m{distance(tracks_[t], clusters[c])};
      if (distance_m) pairs_.push_back({tracks_[t].is_merged, *distance_m, t, c});
    }
  }
  // not stable_sort, which allocates
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.is_merged, a.distance_m, a.track, a.cluster) <
           std::tie(b.is_merged, b.distance_m, b.track, b.cluster);
  });
}

void Tracker::associate(const std::vector<Cluster>& clusters, const Pose2& world_from_vehicle) {
  const auto camera_of = [&](const Cluster& cluster) {
    return composed(world_from_vehicle, camera_place(rig_of(cluster)));
  };
  find_pairs(clusters);
  is_track_taken_.assign(tracks_.size(), 0);
  is_cluster_taken_.assign(clusters.size(), 0);
  for (const Pair& pair : pairs_) {
    if (is_track_taken_[pair.track] != 0 || is_cluster_taken_[pair.cluster] != 0) continue;
    is_track_taken_[pair.track] = is_cluster_taken_[pair.cluster] = 1;
    const Cluster& cluster{clusters[pair.cluster]};
    tracks_[pair.track].is_remembered = !cluster.is_seen;
    if (cluster.is_seen) correct(tracks_[pair.track], cluster, camera_of(cluster));
  }
  for (std::size_t c{0}; c < clusters.size(); ++c) {
    if (is_cluster_taken_[c] == 0 && clusters[c].is_seen) begin_track(clusters[c], camera_of(clusters[c]));
  }
}

void Tracker::begin_track(const Cluster& cluster, const Pose2& camera) {
  const double position_variance{0.3 * 0.3};
  constexpr double unknown{unknown_velocity_mps * unknown_velocity_mps};
  const Symmetric2 velocity_covariance{cluster.has_measured_velocity() ? cluster.velocity_covariance
                                                                       : Symmetric2{unknown, 0, unknown}};
  Track track;
  track.id = next_id_++;
  track.motion = {cluster.centre, position_variance, cluster.velocity, velocity_covariance};
  track.box.begin({cluster, cluster.yaw_rad, camera, rig_of(cluster)}, cluster.yaw_rad, cluster.centre);
  set_shape(track, cluster, camera);
  track.moving = moving_before(cluster);
  track.sightings = cluster.is_sure ? 1 : 0;
  track.pixels = cluster.pixels;
  tracks_.push_back(track);
}

bool Tracker::is_certain(const Track& track) const {
  return track.sightings >= config_.confirm_frames || (track.sightings > 0 && track.pixels >= surely_seen_px);
}

bool Tracker::is_certain(std::int64_t id) const {
  const auto track = std::ranges::find(tracks_, id, &Track::id);
  return track != tracks_.end() && is_certain(*track);
}

Outline Tracker::strips_of(std::int64_t id, const Pose2& vehicle_from_world) const {
  const auto track = std::ranges::find(tracks_, id, &Track::id);
  Outline strips{track == tracks_.end() || track->shape.is_low ? Outline{} : track->shape.outline};
  for (Point2& point : strips) point = vehicle_from_world * point;
  return strips;
}

// Pieces of a thing that moves, of which one has grown to where the other one is. It keeps its older id, whichever
// piece is seen.
void Tracker::merge_movers() {
  for (Track& piece : tracks_) {
    for (Track& whole : tracks_) {
      if (&piece == &whole || piece.is_merged || whole.is_merged || !are_one_mover(piece, whole)) continue;
      const bool is_piece_left{whole.unseen_s > 0 && piece.unseen_s == 0};
      Track& kept{is_piece_left ? piece : whole};
      Track& merged{is_piece_left ? whole : piece};
      merged.is_merged = true;
      if (merged.id < kept.id && merged.unseen_s > 0) {
        std::swap(merged.id, kept.id);
        std::swap(merged.age_s, kept.age_s);
      }
    }
  }
}

// True if the centre of the first is in the second, which is no smaller, and they move alike.
bool Tracker::are_one_mover(const Track& piece, const Track& whole) {
  if (std::min(piece.moving, whole.moving) < surely_moving) return false;
  const auto area_m2 = [](const Track& track) { return track.box.extent_m(0) * track.box.extent_m(1); };
  if (area_m2(piece) > area_m2(whole)) return false;
  const Point2 v{piece.motion.velocity()};
  const Point2 w{whole.motion.velocity()};
  if (std::hypot(v.x - w.x, v.y - w.y) > alike_mps) return false;
  const Point2 at{piece.middle()};
  const Point2 from{whole.middle()};
  const double c{std::cos(whole.box.yaw_rad)};
  const double s{std::sin(whole.box.yaw_rad)};
  const Point2 away{at.x - from.x, at.y - from.y};
  return 2 * std::abs(c * away.x + s * away.y) < whole.box.extent_m(0) &&
         2 * std::abs(c * away.y - s * away.x) < whole.box.extent_m(1);
}

// Time limit for unobserved tracks: twice their observed time, so that fragments of a frame end with it.
bool Tracker::is_expired(const Track& track, bool is_looked_at) const {
  if (!is_looked_at) return track.unseen_s > config_.coast_s;
  const double seen_s{track.age_s - track.unseen_s};
  return track.unseen_s > std::min(config_.coast_s, 2 * seen_s) || !is_certain(track) ||
         (track.is_merged && seen_s < known_s);
}

bool Tracker::is_in_view(Point2 at, Cameras cameras) const {
  for (std::size_t i{0}; i < rigs_.size(); ++i) {
    if ((cameras >> i & 1U) != 0 && is_in_view_of(rigs_[i], at)) return true;
  }
  return false;
}

bool Tracker::is_over(const Track& track, const std::vector<Cluster>& clusters, const GridLayers& world,
                      const Pose2& vehicle_from_world) const {
  const Point2 place{track.middle()};
  const Point2 at{vehicle_from_world * place};
  // no later frame can show whether it is still there, unless it moves into the view of the next camera
  if (!is_in_view(at)) return rigs_.size() == 1 || track.moving < surely_moving;
  if (track.unseen_s > gone_s && track.moving < surely_moving && !is_hidden(at, clusters, vehicle_from_world))
    return true;
  const GridGeometry& grid{world.geometry};
  const auto cell = grid.cell_at(place);
  if (!cell) return true;
  return track.unseen_s > gone_s && world.occupancy(cell->ix, cell->iy) < free_occupancy &&
         world.age_s(cell->ix, cell->iy) == 0;
}

// True if something nearer hides it.
bool Tracker::is_hidden(Point2 at, const std::vector<Cluster>& clusters, const Pose2& vehicle_from_world) const {
  return std::any_of(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
    const Rig& rig{rig_of(cluster)};
    if (rigs_.size() > 1 && !is_in_view_of(rig, at)) return false;
    const Pose2 camera_from_vehicle{inverse(camera_place(rig))};
    const Pose2 camera_from_world{composed(camera_from_vehicle, vehicle_from_world)};
    const Point2 place{camera_from_vehicle * at};
    const double slope{place.y / place.x};
    constexpr double far{std::numeric_limits<double>::max()};
    double least{far};
    double most{-far};
    double nearest{far};
    if (cluster.kind == ObstacleKind::drop || cluster.is_low) return false;
    for (const Point2& point : cluster.outline) {
      const Point2 here{camera_from_world * point};
      if (!(here.x > 0)) continue;
      least = std::min(least, here.y / here.x);
      most = std::max(most, here.y / here.x);
      nearest = std::min(nearest, here.x);
    }
    return least < slope && slope < most && nearest < place.x - hidden_by_m;
  });
}

// True if at least half of the track is now part of another thing, or of several.
bool Tracker::is_replaced(const Track& track, const std::vector<Cluster>& clusters) {
  if (track.moving >= surely_moving) return false;  // it may be hidden behind that
  const Outline& outline{track.shape.outline};
  std::array<bool, Outline::points_max> is_taken{};
  for (const Cluster& cluster : clusters) {
    if (cluster.kind != ObstacleKind::object || (cluster.is_low && !track.shape.is_low)) continue;
    if (track.shape.bounds.gap_to(cluster.bounds, track.moved) >= replaced_within_m) continue;
    for (std::size_t i{0}; i < outline.size(); ++i) {
      const Point2 at{outline[i].x + track.moved.x, outline[i].y + track.moved.y};
      is_taken[i] = is_taken[i] || cluster.bounds.gap_to({at, at}, {}) < replaced_within_m;
    }
  }
  return 2 * static_cast<std::size_t>(std::ranges::count(is_taken, true)) >= outline.size();
}

}  // namespace stereogrid
