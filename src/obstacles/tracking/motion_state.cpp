// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "obstacles/tracking/motion_state.hpp"

#include <cmath>

namespace stereogrid {
namespace {

// Yaw rate of an unobserved object: standard deviation, and time constant of its decay.
constexpr double yaw_rate_sigma_radps{0.3};
constexpr double yaw_rate_lasts_s{6};
/// In standard deviations.
constexpr double sure_from{2};

}  // namespace

MotionState::MotionState(Point2 place, double place_variance, Point2 velocity, const Symmetric2& velocity_covariance)
    : mean_{place.x, place.y, velocity.x, velocity.y, 0} {
  const auto set = [this](std::size_t row, std::size_t column, double value) {
    covariance_[row * size + column] = covariance_[column * size + row] = value;
  };
  set(0, 0, place_variance);
  set(1, 1, place_variance);
  set(2, 2, velocity_covariance.xx);
  set(2, 3, velocity_covariance.xy);
  set(3, 3, velocity_covariance.yy);
  set(4, 4, yaw_rate_sigma_radps * yaw_rate_sigma_radps);
}

double MotionState::yaw_rate_radps() const {
  return std::abs(mean_[4]) > sure_from * std::sqrt(at(4, 4)) ? mean_[4] : 0;
}

void MotionState::predict(double dt_s, double acceleration_mps2) {
  const double turned_rad{yaw_rate_radps() * dt_s};
  const double c{std::cos(turned_rad)};
  const double s{std::sin(turned_rad)};
  const Point2 before{velocity()};
  const Point2 after{c * before.x - s * before.y, s * before.x + c * before.y};
  const double kept{std::exp(-dt_s / yaw_rate_lasts_s)};
  const double half_s{dt_s / 2};
  mean_ = {mean_[0] + half_s * (before.x + after.x), mean_[1] + half_s * (before.y + after.y), after.x, after.y,
           kept * mean_[4]};
  const std::array<Vector, size> f{
      Vector{1, 0, half_s * (1 + c), -half_s * s, -dt_s * half_s * after.y},
      Vector{0, 1, half_s * s, half_s * (1 + c), dt_s * half_s * after.x},
      Vector{0, 0, c, -s, -dt_s * after.y},
      Vector{0, 0, s, c, dt_s * after.x},
      Vector{0, 0, 0, 0, kept},
  };
  std::array<double, size * size> moved{};  // f · covariance
  std::array<double, size * size> result{};
  for (std::size_t i{0}; i < size * size; ++i) {
    for (std::size_t k{0}; k < size; ++k) moved[i] += f[i / size][k] * at(k, i % size);
  }
  for (std::size_t i{0}; i < size * size; ++i) {
    for (std::size_t k{0}; k < size; ++k) result[i] += moved[i / size * size + k] * f[i % size][k];
  }
  covariance_ = result;
  const double q{acceleration_mps2 * acceleration_mps2 * dt_s * dt_s};
  for (std::size_t axis{0}; axis < 2; ++axis) {
    covariance_[axis * (size + 1)] += q * dt_s * dt_s / 4;
    covariance_[axis * (size + 1) + 2] += q * dt_s / 2;
    covariance_[axis * (size + 1) + 2 * size] += q * dt_s / 2;
    covariance_[(axis + 2) * (size + 1)] += q;
  }
  covariance_[4 * (size + 1)] += (1 - kept * kept) * yaw_rate_sigma_radps * yaw_rate_sigma_radps;
}

void MotionState::measure(std::size_t first, Point2 direction, double measured, double variance) {
  Vector column{};
  for (std::size_t i{0}; i < size; ++i) column[i] = at(i, first) * direction.x + at(i, first + 1) * direction.y;
  const double spread{column[first] * direction.x + column[first + 1] * direction.y + variance};
  if (!(spread > 0)) return;  // known already, as surely as it is measured
  const double innovation{measured - mean_[first] * direction.x - mean_[first + 1] * direction.y};
  for (std::size_t i{0}; i < size; ++i) mean_[i] += column[i] / spread * innovation;
  for (std::size_t i{0}; i < size * size; ++i) covariance_[i] -= column[i / size] * column[i % size] / spread;
}

// Along the axes of the covariance, in which the measurement errors are independent.
void MotionState::measure_velocity(const Point2& velocity, const Symmetric2& covariance) {
  const double angle{0.5 * std::atan2(2 * covariance.xy, covariance.xx - covariance.yy)};
  for (const Point2 axis : {Point2{std::cos(angle), std::sin(angle)}, Point2{-std::sin(angle), std::cos(angle)}}) {
    measure(2, axis, velocity.x * axis.x + velocity.y * axis.y, squared(covariance, axis));
  }
}

void MotionState::stand_still() {
  mean_[2] = mean_[3] = mean_[4] = 0;
}

}  // namespace stereogrid
