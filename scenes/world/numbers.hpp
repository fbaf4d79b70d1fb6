// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

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

/// Spreads every bit of the input over all bits of the output (lowbias32).
[[nodiscard]] inline std::uint32_t scramble(std::uint32_t bits) {
  bits ^= bits >> 16;
  bits *= 0x7feb352dU;
  bits ^= bits >> 15;
  bits *= 0x846ca68bU;
  return bits ^ (bits >> 16);
}

/// The same for 64 bits (the finaliser of SplitMix64).
[[nodiscard]] inline std::uint64_t scramble(std::uint64_t bits) {
  bits += 0x9e3779b97f4a7c15U;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebU;
  return bits ^ (bits >> 31);
}

/// Random numbers for layouts. The standard library's distributions differ from one implementation to the next.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_{scramble(seed)} {}

  [[nodiscard]] double between(double low, double high) {
    state_ = scramble(state_);
    return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// Standard normal noise, the sum of four uniform numbers cut from 64 well-spread bits.
[[nodiscard]] inline double gaussian(std::uint64_t bits) {
  constexpr double mean{2 * 65535.0};
  constexpr double sigma{37837.0};  // 65536 · sqrt(4/12)
  const std::uint64_t sum{(bits & 0xffff) + ((bits >> 16) & 0xffff) + ((bits >> 32) & 0xffff) + (bits >> 48)};
  return (static_cast<double>(sum) - mean) / sigma;
}

}  // namespace stereogrid::scenes
