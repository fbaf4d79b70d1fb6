// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "truth_cells.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr float occupied_from{0.5F};
constexpr float gone_below{0.3F};
constexpr double soon_s{0.5};

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
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

}  // namespace stereogrid::evaluation
