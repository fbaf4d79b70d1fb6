// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace stereogrid::scenes {

constexpr double pi{3.14159265358979323846};

/// A unit vector on the ground plane.
struct Direction {
  double cosine{1};
  double sine{0};
};

/// Sine and cosine by their series: libm's differ in the last bit from machine to machine, and the images must not.
[[nodiscard]] inline Direction direction_of(double angle_rad) {
  const double turn{std::remainder(angle_rad, 2 * pi)};
  const double quadrant{std::round(turn / (pi / 2))};
  const double x{turn - quadrant * (pi / 2)};
  double cosine{1};
  double sine{x};
  double cosine_term{1};
  double sine_term{x};
  for (int n{2}; n <= 20; n += 2) {
    cosine_term *= -x * x / ((n - 1) * n);
    sine_term *= -x * x / (n * (n + 1));
    cosine += cosine_term;
    sine += sine_term;
  }
  switch (static_cast<int>(quadrant) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

}  // namespace stereogrid::scenes
