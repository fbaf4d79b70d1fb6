// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "motion/symmetric2.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Kalman filter of place, velocity and yaw rate of an object on the ground: white acceleration, and a velocity that
/// turns by the yaw rate. World axes. docs/method.md §11.2.
class MotionState {
 public:
  MotionState() = default;
  MotionState(Point2 place, double place_variance, Point2 velocity, const Symmetric2& velocity_covariance);

  void predict(double dt_s, double acceleration_mps2);
  /// Measures the place along `direction`, a unit vector.
  void measure_place(Point2 direction, double place_m, double variance) { measure(0, direction, place_m, variance); }
  void measure_velocity(const Point2& velocity, const Symmetric2& covariance);
  void stand_still();

  [[nodiscard]] Point2 place() const { return {mean_[0], mean_[1]}; }
  [[nodiscard]] Point2 velocity() const { return {mean_[2], mean_[3]}; }
  [[nodiscard]] Symmetric2 place_covariance() const { return {at(0, 0), at(0, 1), at(1, 1)}; }
  [[nodiscard]] Symmetric2 velocity_covariance() const { return {at(2, 2), at(2, 3), at(3, 3)}; }
  /// Yaw rate of the velocity; 0 if not significant.
  [[nodiscard]] double yaw_rate_radps() const;

 private:
  static constexpr std::size_t size{5};
  using Vector = std::array<double, size>;

  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return covariance_[row * size + column]; }
  void measure(std::size_t first, Point2 direction, double measured, double variance);

  Vector mean_{};  // x, y, vx, vy, yaw rate
  std::array<double, size * size> covariance_{};
};

/// A side of the box around an outline, square to an axis.
struct BoxSide {
  double at_m{0};       ///< along the axis
  double sigma_m{0};    ///< infinite: it is hidden, or cut off, or only assumed
  bool is_near{false};  ///< visible to the camera, or both ends of a facing side: later observations are of the same
                        ///< side

  [[nodiscard]] bool is_seen() const;
};

/// Sides of the box around a cluster's outline, with standard deviations. docs/method.md §11.2.
struct BoxView {
  /// `camera`: position and viewing direction, world axes.
  BoxView(const Cluster& cluster, double yaw_rad, const Pose2& camera, const Rig& rig);

  std::array<Point2, 2> axes;                     ///< along yaw_rad, and across it
  std::array<std::array<BoxSide, 2>, 2> sides{};  ///< by axis, the side with the smaller coordinate first

  /// Standard deviation of the visible side along yaw_rad; infinite: none visible.
  [[nodiscard]] double face_sigma_m() const;
};

/// Box of a thing from all frames: its sides around a reference point that is fixed on the thing.
struct TrackedBox {
  double yaw_rad{0};
  std::array<std::array<double, 2>, 2> reach_m{};  ///< by axis: coordinates of its sides, from the reference point
  std::array<std::array<double, 2>, 2> sigma_m{};  ///< by side; infinite: never seen

  /// As it is seen now.
  void begin(const BoxView& view, double yaw, Point2 place);
  /// After the place has been corrected.
  void update(const BoxView& view, Point2 place);
  /// Centre of the box, from the reference point.
  [[nodiscard]] Point2 middle() const;
  [[nodiscard]] double extent_m(std::size_t axis) const { return reach_m[axis][1] - reach_m[axis][0]; }
  /// Infinite: an end has never been seen.
  [[nodiscard]] double extent_sigma_m(std::size_t axis) const;
};

}  // namespace stereogrid
