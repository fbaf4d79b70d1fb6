// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/evaluation/ray_casting.hpp"

namespace stereogrid::evaluation {

/// Hits on cells and rays through them.
struct RayCounts {
  Image<float> hits;
  Image<float> passes;
};

/// Rays from one point in fixed directions; how many end where is counted in steps of length.
class Fan {
 public:
  /// `directions` need not have length 1: lengths are counted in multiples of them.
  Fan(Point2 origin, std::vector<Point2> directions, double length, double step);

  /// A ray that ends after `length`, on an obstacle or on the road.
  void add(std::size_t direction, double length, bool is_hit);

  /// Counts them on the cells of a grid which lies there as seen from the fan's frame. Rays pass the cells before the
  /// one they end in; those that end on the road pass that one too.
  [[nodiscard]] RayCounts cast(const GridGeometry& grid, const Pose2& grid_from_fan) const;

 private:
  void cast_direction(std::size_t direction, const GridGeometry& grid, const Pose2& grid_from_fan,
                      RayCounts& counts) const;
  [[nodiscard]] float ending_beyond(const std::vector<float>& beyond, double length) const;

  Point2 origin_;
  std::vector<Point2> directions_;
  double step_;
  Image<float> hits_;  // (directions, steps)
  Image<float> ends_;
};

/// Distance from the vehicle's origin to the grid's farthest corner.
[[nodiscard]] double farthest_corner_m(const GridGeometry& grid);

/// Clamped log-odds of every cell.
[[nodiscard]] Image<float> log_odds_of(const RayCounts& counts, const LogOddsParameters& parameters);
[[nodiscard]] Image<float> probabilities_of(Image<float> log_odds);

}  // namespace stereogrid::evaluation
