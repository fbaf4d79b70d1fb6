// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "stereogrid/evaluation/motion.hpp"

namespace stereogrid::evaluation {

inline constexpr double moving_above_mps{0.3};
inline constexpr std::int64_t matched_pixels_min{100};
inline constexpr double match_within_m{2};

[[nodiscard]] inline bool is_inside(const GridGeometry& grid, Point2 p) {
  return p.x >= grid.x_min_m && p.x < grid.x_min_m + grid.nx * grid.cell_size_m && p.y >= grid.y_min_m &&
         p.y < grid.y_min_m + grid.ny * grid.cell_size_m;
}

/// The nearest confirmed obstacle within 2 m; none: nullptr.
[[nodiscard]] inline const Obstacle* nearest_confirmed(std::span<const Obstacle> found, Point2 place) {
  const Obstacle* best{nullptr};
  double smallest{match_within_m};
  for (const Obstacle& obstacle : found) {
    const double distance{std::hypot(obstacle.x_m - place.x, obstacle.y_m - place.y)};
    if (!obstacle.confirmed || distance > smallest) continue;
    smallest = distance;
    best = &obstacle;
  }
  return best;
}

/// Calls visit(truth cell, grid cell) with indices into both for every cell that the two grids share.
template <class Visit>
void for_shared_cells(const MotionFrame& frame, Visit visit) {
  const CellShift shift{shift_between(frame.grid, frame.truth_grid.geometry)};
  for (int ty{0}; ty < frame.truth.state.height(); ++ty) {
    for (int tx{0}; tx < frame.truth.state.width(); ++tx) {
      const int ix{tx + shift.x};
      const int iy{ty + shift.y};
      if (ix < 0 || iy < 0 || ix >= frame.grid.nx || iy >= frame.grid.ny) continue;
      visit(tx, ty, ix, iy);
    }
  }
}

[[nodiscard]] inline TruthCell state_at(const FrameTruth& truth, int tx, int ty) {
  return static_cast<TruthCell>(truth.state(tx, ty));
}

[[nodiscard]] inline bool is_moving(const FrameTruth& truth, int tx, int ty) {
  return std::hypot(truth.velocity_x(tx, ty), truth.velocity_y(tx, ty)) > moving_above_mps;
}

[[nodiscard]] inline bool is_moving(const TruthObject& object) {
  return std::hypot(object.vx_mps, object.vy_mps) > moving_above_mps;
}

}  // namespace stereogrid::evaluation
