// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "motion/symmetric2.hpp"
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

}  // namespace stereogrid
