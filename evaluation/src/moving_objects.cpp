// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "stereogrid/evaluation/motion.hpp"
#include "truth_cells.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr float occupied_from{0.5F};
constexpr float gone_below{0.3F};
constexpr double soon_s{0.5};

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

constexpr std::int64_t seen_from_pixels{100};

struct Mean {
  double sum{0};
  double cells{0};
};

/// Mean p over the cells below each object.
std::map<std::int64_t, Mean> means_by_object(const MotionFrame& frame) {
  std::map<std::int64_t, Mean> means;
  for_shared_cells(frame, [&](int tx, int ty, int ix, int iy) {
    if (frame.truth.occupied(tx, ty) == 0) return;
    Mean& mean{means[frame.truth.owner(tx, ty)]};
    mean.sum += static_cast<double>(frame.occupancy(ix, iy));
    mean.cells += 1;
  });
  return means;
}

/// Its place lies within the image's columns, so that only other things can hide it.
bool is_ahead(const MotionFrame& frame, const TruthObject& object) {
  const Point2 place{inverse(frame.truth.ego.world_from_vehicle) *
                     Point2{object.world_from_object.x_m, object.world_from_object.y_m}};
  if (place.x <= 0) return false;
  const double u{frame.rig.cx_px - frame.rig.focal_px * place.y / place.x};
  return u >= 0 && u < frame.rig.width_px;
}

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

void GhostTimes::add(const MotionFrame& frame) {
  now_ns_ = frame.truth.stamp_ns;
  follow(frame);
  watch(frame);
}

void GhostTimes::follow(const MotionFrame& frame) {
  const CellShift shift{shift_between(frame.grid, frame.truth_grid.geometry)};
  const Pose2 vehicle_from_world{inverse(frame.truth.ego.world_from_vehicle)};
  const double size_m{frame.grid.cell_size_m};
  for (auto entry{watched_.begin()}; entry != watched_.end();) {
    const auto [cell, free_since]{*entry};
    const Point2 place{vehicle_from_world * Point2{(cell.first + 0.5) * size_m, (cell.second + 0.5) * size_m}};
    const int ix{static_cast<int>(std::floor((place.x - frame.grid.x_min_m) / size_m))};
    const int iy{static_cast<int>(std::floor((place.y - frame.grid.y_min_m) / size_m))};
    const int tx{ix - shift.x};
    const int ty{iy - shift.y};
    const bool inside{ix >= 0 && iy >= 0 && ix < frame.grid.nx && iy < frame.grid.ny && tx >= 0 && ty >= 0 &&
                      tx < frame.truth.state.width() && ty < frame.truth.state.height()};
    const TruthCell state{inside ? state_at(frame.truth, tx, ty) : TruthCell::hidden};
    if (state != TruthCell::seen_free) {
      if (free_since) left_.push_back({seconds_between(*free_since, now_ns_), false});
      // hidden before it was ever seen free: its time has not begun
      entry = inside && !free_since ? std::next(entry) : watched_.erase(entry);
      continue;
    }
    const std::int64_t since_ns{free_since.value_or(now_ns_)};
    entry->second = since_ns;
    const bool fell{frame.occupancy(ix, iy) < gone_below};
    if (fell) left_.push_back({seconds_between(since_ns, now_ns_), true});
    entry = fell ? watched_.erase(entry) : std::next(entry);
  }
}

void GhostTimes::watch(const MotionFrame& frame) {
  const double size_m{frame.grid.cell_size_m};
  for_shared_cells(frame, [&](int tx, int ty, int ix, int iy) {
    if (state_at(frame.truth, tx, ty) != TruthCell::seen_occupied || !is_moving(frame.truth, tx, ty)) return;
    if (frame.occupancy(ix, iy) < occupied_from) return;
    const Point2 place{frame.truth.ego.world_from_vehicle *
                       Point2{frame.grid.x_min_m + (ix + 0.5) * size_m, frame.grid.y_min_m + (iy + 0.5) * size_m}};
    watched_[{static_cast<int>(std::floor(place.x / size_m)), static_cast<int>(std::floor(place.y / size_m))}] =
        std::nullopt;
  });
}

std::vector<double> GhostTimes::seconds() const {
  std::vector<double> all;
  for (const Left& left : left_) all.push_back(left.seconds);
  for (const auto& [cell, free_since] : watched_) {
    if (free_since) all.push_back(seconds_between(*free_since, now_ns_));
  }
  return all;
}

double GhostTimes::gone_within_half_second() const {
  double gone{0};
  double stayed{0};
  for (const Left& left : left_) {
    if (left.seconds > soon_s) {
      stayed += 1;
    } else if (left.fell) {
      gone += 1;
    }
  }
  for (const auto& [cell, free_since] : watched_) {
    if (free_since && seconds_between(*free_since, now_ns_) > soon_s) stayed += 1;
  }
  return gone + stayed > 0 ? gone / (gone + stayed) : std::numeric_limits<double>::quiet_NaN();
}

void HiddenSurvival::add(const MotionFrame& frame) {
  const std::map<std::int64_t, Mean> means{means_by_object(frame)};
  for (const TruthObject& object : frame.truth.objects) {
    if (object.pixels >= seen_from_pixels) seen_.insert(object.id);
    const auto mean{means.find(object.id)};
    const bool hidden{object.pixels == 0 && seen_.contains(object.id) && is_ahead(frame, object)};
    if (hidden && mean != means.end()) {
      extend(object.id, frame.truth.stamp_ns, mean->second.sum / mean->second.cells);
    } else {
      close(object.id);
    }
  }
}

void HiddenSurvival::extend(std::int64_t id, std::int64_t stamp_ns, double mean) {
  Open& open{open_.try_emplace(id, Open{stamp_ns, stamp_ns, std::nullopt, {}}).first->second};
  open.last_ns = stamp_ns;
  ++open.counts.frames;
  if (mean >= occupied_from) {
    ++open.counts.alive;
  } else if (!open.lost_ns) {
    open.lost_ns = stamp_ns;
  }
}

void HiddenSurvival::close(std::int64_t id) {
  const auto found{open_.find(id)};
  if (found == open_.end()) return;
  const Open& open{found->second};
  Episode episode{open.counts};
  episode.hidden_s = static_cast<double>(open.last_ns - open.since_ns) * 1e-9;
  episode.survived_s = static_cast<double>(open.lost_ns.value_or(open.last_ns) - open.since_ns) * 1e-9;
  finished_.push_back(episode);
  open_.erase(found);
}

std::vector<HiddenSurvival::Episode> HiddenSurvival::episodes() const {
  HiddenSurvival ended{*this};
  for (const auto& [id, open] : open_) ended.close(id);
  return ended.finished_;
}

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
