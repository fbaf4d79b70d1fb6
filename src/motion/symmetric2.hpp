// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "stereogrid/frame.hpp"

namespace stereogrid {

/// Symmetric 2 × 2 matrix: a covariance, or its inverse.
struct Symmetric2 {
  double xx{0};
  double xy{0};
  double yy{0};
};

/// pᵀ m p
inline double squared(const Symmetric2& m, Point2 p) {
  return m.xx * p.x * p.x + 2 * m.xy * p.x * p.y + m.yy * p.y * p.y;
}

inline Point2 operator*(const Symmetric2& m, Point2 p) {
  return {m.xx * p.x + m.xy * p.y, m.xy * p.x + m.yy * p.y};
}

inline Symmetric2 operator+(const Symmetric2& a, const Symmetric2& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
}

inline Symmetric2 operator*(double factor, const Symmetric2& m) {
  return {factor * m.xx, factor * m.xy, factor * m.yy};
}

/// m + variance · identity
inline Symmetric2 widened(const Symmetric2& m, double variance) {
  return {m.xx + variance, m.xy, m.yy + variance};
}

inline Symmetric2 inverted(const Symmetric2& m) {
  const double determinant{m.xx * m.yy - m.xy * m.xy};
  return {m.yy / determinant, -m.xy / determinant, m.xx / determinant};
}

/// Unit vector along which a covariance is largest, x >= 0; {1, 0} where it is the same in all directions.
inline Point2 principal_direction(const Symmetric2& m) {
  const double difference{m.xx - m.yy};
  const double length{std::sqrt(difference * difference + 4 * m.xy * m.xy)};
  const double cosine{length > 0 ? difference / length : 1.0};  // cosine of twice the angle
  return {std::sqrt(0.5 * (1 + cosine)), std::copysign(std::sqrt(0.5 * (1 - cosine)), m.xy)};
}

/// A sum of measurements of the same thing, each weighted by its information (the inverse of its covariance).
struct InformationSum {
  Symmetric2 information;
  Point2 weighted;
  double squares{0};

  InformationSum() = default;
  /// Information of one measurement.
  InformationSum(const Symmetric2& j, Point2 value) : information{j}, weighted{j * value}, squares{squared(j, value)} {}

  void add(const InformationSum& other, double weight = 1) {
    information.xx += weight * other.information.xx;
    information.xy += weight * other.information.xy;
    information.yy += weight * other.information.yy;
    weighted.x += weight * other.weighted.x;
    weighted.y += weight * other.weighted.y;
    squares += weight * other.squares;
  }
  [[nodiscard]] Point2 mean() const { return inverted(information) * weighted; }
  /// Summed squared Mahalanobis distances from the mean.
  [[nodiscard]] double misfit() const {
    const double left{squares - squared(information, mean())};
    return left > 0 ? left : 0;
  }
};

}  // namespace stereogrid
