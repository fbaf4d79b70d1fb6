// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string_view>

#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Symmetric, 2 × 2.
struct Covariance2 {
  double xx{0};
  double xy{0};
  double yy{0};
};

enum class ObstacleKind : std::uint8_t {
  object,    ///< car, person, cycle, pole, box: the vehicle can go around it
  boundary,  ///< wall, hedge, façade, or a row of objects that cannot be separated
  drop,      ///< edge behind which the ground is lower (docs/terrain.md)
};
constexpr std::array<std::string_view, 3> names_of(ObstacleKind) {
  return {"object", "boundary", "drop"};
}

/// Points on the ground, m, one after another. A fixed number has room: nothing is allocated.
class STEREOGRID_EXPORT Outline {
 public:
  static constexpr std::size_t points_max{48};

  constexpr Outline() = default;
  constexpr Outline(std::initializer_list<Point2> points) {
    for (const Point2& point : points) push_back(point);
  }

  /// What has no room is left out.
  constexpr void push_back(Point2 point) {
    if (size_ < points_max) points_[size_++] = point;
  }
  constexpr void clear() { size_ = 0; }
  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
  [[nodiscard]] constexpr const Point2& operator[](std::size_t i) const { return points_[i]; }
  [[nodiscard]] constexpr Point2* begin() { return points_.data(); }
  [[nodiscard]] constexpr Point2* end() { return points_.data() + size_; }
  [[nodiscard]] constexpr const Point2* begin() const { return points_.data(); }
  [[nodiscard]] constexpr const Point2* end() const { return points_.data() + size_; }

 private:
  std::array<Point2, points_max> points_{};
  std::size_t size_{0};
};

/// A tracked object, boundary or drop. Positions in the vehicle frame of the same instant; velocities
/// relative to the ground, in vehicle axes.
struct Obstacle {
  std::int64_t id{0};  ///< stays with the obstacle for as long as it is tracked; never used again
  double x_m{0};       ///< centre of its box
  double y_m{0};
  double vx_mps{0};
  double vy_mps{0};
  double length_m{0};   ///< extent along yaw_rad
  double width_m{0};    ///< extent across yaw_rad
  double yaw_rad{0};    ///< of the motion where it moves, else of the longer side
  double occupancy{0};  ///< mean P(occupied) of the cells in which it is seen
  double age_s{0};      ///< since it was first seen
  bool confirmed{false};
  bool moving{false};               ///< faster than 1 m/s; until several frames have shown motion, its velocity is 0
  bool coasting{false};             ///< not seen in this frame: carried on where it was hidden or missed
  double unseen_s{0};               ///< since it was last seen
  Covariance2 position_covariance;  ///< m², vehicle axes
  Covariance2 velocity_covariance;  ///< m²/s², vehicle axes
  ObstacleKind kind{ObstacleKind::object};
  /// Above the road, of nine in ten of its columns; what hangs above a gap does not count. Of a drop negative: the
  /// visible part of its fall.
  double height_m{0};
  /// Visible part where it was last seen, moved on with it: of an object a simple polygon, at least as deep as half a
  /// metre; of a boundary or a drop an open line along its near side, from left to right.
  Outline outline;
  /// Of its velocity's direction, to the left; 0 where it does not move, or does not surely turn.
  double yaw_rate_radps{0};
  /// Standard deviations of the box; infinite: unknown. Of length and width only of what moves, and where both ends
  /// have been seen, neither hidden nor cut off by the image; of the heading of what stands only where it is longer
  /// than wide by 1.4.
  double length_sigma_m{std::numeric_limits<double>::infinity()};
  double width_sigma_m{std::numeric_limits<double>::infinity()};
  double yaw_sigma_rad{std::numeric_limits<double>::infinity()};
};

}  // namespace stereogrid
