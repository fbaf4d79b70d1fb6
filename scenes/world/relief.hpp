// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "world/height_field.hpp"

namespace stereogrid::scenes {

/// Straight pieces between points by ascending `at`, level before the first and after the last one. Two points of equal
/// `at` are a step. No points: 0.
class Polyline {
 public:
  struct Point {
    double at{0};
    double value{0};
  };

  Polyline() = default;
  Polyline(std::vector<Point> points) : points_{std::move(points)} {}

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] Point last() const { return points_.back(); }
  /// Value at `at` of the piece that holds `beside`.
  [[nodiscard]] double value(double at, double beside) const;

  /// Continues to a point.
  Polyline& to(double at, double value);
  /// Continues over `length_m` with a slope (tangent) that changes evenly, in eight pieces, from one to the other.
  Polyline& bend(double from_slope, double to_slope, double length_m);
  /// Continues over `length_m` by half a period of a cosine.
  Polyline& wave(double rise, double length_m);

 private:
  std::vector<Point> points_;
};

/// 1 everywhere.
[[nodiscard]] Polyline everywhere();
/// 1 between two places, 0 elsewhere.
[[nodiscard]] Polyline between(double low, double high);

/// Shapes whose heights add up to a height field. The height of a shape is along(x) · across(y).
class Relief {
 public:
  void add(Polyline along, Polyline across = everywhere());
  [[nodiscard]] HeightField field() const;

 private:
  struct Product {
    Polyline along;
    Polyline across;
  };
  std::vector<Product> shapes_;
};

}  // namespace stereogrid::scenes
