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

/// Kinds of obstacles.
enum class ObstacleKind : std::uint8_t {
  object,    ///< car, person, cycle, pole, box: the vehicle can go around it
  boundary,  ///< wall, hedge, façade, or a row of objects that cannot be separated
  drop,      ///< edge behind which the ground is lower (docs/terrain.md)
};
constexpr std::array<std::string_view, 3> names_of(ObstacleKind) {
  return {"object", "boundary", "drop"};
}

/// Points on the ground, m, in order. Fixed capacity: nothing is allocated.
class STEREOGRID_EXPORT Outline {
 public:
  static constexpr std::size_t points_max{48};

  constexpr Outline() = default;
  constexpr Outline(std::initializer_list<Point2> points) {
    for (const Point2& point : points) push_back(point);
  }

  /// Appends a point; points beyond the capacity are dropped.
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
  std::uint64_t size_{0};  // 64 bits on every machine: no padding
};

/// Tracked object, boundary or drop. Positions in the vehicle frame of the same instant; velocities relative to the
/// ground, in vehicle axes.
struct Obstacle {
  std::int64_t id{0};  ///< constant while the obstacle is tracked; never reused
  double x_m{0};       ///< centre of the box
  double y_m{0};
  double vx_mps{0};
  double vy_mps{0};
  double length_m{0};               ///< extent along yaw_rad
  double width_m{0};                ///< extent across yaw_rad
  double yaw_rad{0};                ///< heading of the motion, or of the longer side if static
  double occupancy{0};              ///< mean P(occupied) of its cells
  double age_s{0};                  ///< time since the first observation
  bool confirmed{false};            ///< observed in tracking.confirm_frames frames, or with 300 pixels in all, and not
                                    ///< beside the vehicle grid
  bool moving{false};               ///< faster than 1 m/s; its velocity is 0 until several frames have shown motion
  bool coasting{false};             ///< not observed in this frame: predicted
  double unseen_s{0};               ///< time since the last observation
  Covariance2 position_covariance;  ///< m², vehicle axes
  Covariance2 velocity_covariance;  ///< m²/s², vehicle axes
  ObstacleKind kind{ObstacleKind::object};
  /// Above the road, 0.9 quantile over its columns; parts above a gap do not count. Of a drop negative: the visible
  /// part of its fall.
  double height_m{0};
  /// Outline of the visible part at the last observation, moved with the track. Object: a simple polygon of at most 8
  /// points, at least half a metre deep but for low obstacles. Boundary: an open line of at most 12 points along the
  /// near side, from left to right. Drop: an open line.
  Outline outline;
  /// Yaw rate of the velocity's direction, positive to the left; 0 if the obstacle is static or the rate is not
  /// significant.
  double yaw_rate_radps{0};
  /// Standard deviations of the box; infinite: unknown. Length and width are known only for dynamic obstacles whose
  /// ends have both been seen, neither hidden nor cut off by the image. The heading of a static obstacle is known only
  /// if it is longer than wide by 1.4.
  double length_sigma_m{std::numeric_limits<double>::infinity()};
  double width_sigma_m{std::numeric_limits<double>::infinity()};
  double yaw_sigma_rad{std::numeric_limits<double>::infinity()};
};

}  // namespace stereogrid
