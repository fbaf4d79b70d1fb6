// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "host_device.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Terms of RowOffsets.
constexpr std::size_t row_terms{5};
using RowTerms = std::array<double, row_terms>;

/// By how many rows a point lies lower in the right image than in the left one, as a function of its place in the right
/// image: what is left over when a pair has been rectified with slightly wrong rotation and lenses.
/// terms · (1, x, y, x·y, x²) with x = (u − u0)/400 and y = (v − v0)/100: pitch, roll, scale, yaw, lens.
struct RowOffsets {
  RowTerms terms{};  ///< px
  double centre_u_px{0};
  double centre_v_px{0};

  [[nodiscard]] STEREOGRID_HD RowTerms basis(double u, double v) const {
    const double x{(u - centre_u_px) / 400};
    const double y{(v - centre_v_px) / 100};
    return {1, x, y, x * y, x * x};
  }

  [[nodiscard]] STEREOGRID_HD double at(double u, double v) const {
    const RowTerms factors{basis(u, v)};
    double sum{0};
    for (std::size_t i{0}; i < row_terms; ++i) sum += terms[i] * factors[i];
    return sum;
  }
};

/// The offsets along an image row in fixed point, so that every back end rounds alike.
struct OffsetRow {
  std::int32_t start{0};  ///< at u = 0, in 1/2^20 px
  std::int32_t slope{0};  ///< per column there, in 1/2^20 px
  std::int32_t bend{0};   ///< per column squared, in 1/2^30 px

  /// In 1/256 px.
  [[nodiscard]] STEREOGRID_HD std::int32_t at(int u) const {
    return (start + (slope + (bend * u >> 10)) * u + (1 << 11)) >> 12;
  }
};

/// What is far from any rectified pair is cut off: ±512 px, slopes beyond ±1/32, bends beyond 1/2^16; columns up to
/// 8192.
STEREOGRID_HD inline OffsetRow offset_row(const RowOffsets& offsets, int v) {
  const auto fixed = [](double value, double limit) {
    const double bounded{value < -limit ? -limit : (value > limit ? limit : value)};
    return static_cast<std::int32_t>(bounded < 0 ? bounded - 0.5 : bounded + 0.5);
  };
  constexpr double one{1 << 20};
  const double before{offsets.at(-1, v)};
  const double at_start{offsets.at(0, v)};
  const double after{offsets.at(1, v)};
  const double bend{(before + after) / 2 - at_start};
  return {fixed(at_start * one, 512 * one), fixed((after - before) / 2 * one, one / 32),
          fixed(bend * 1024 * one, one / 64)};
}

/// Grey level between two rows, `part` / 256 below the upper one.
STEREOGRID_HD inline std::uint8_t between_rows(std::uint8_t upper, std::uint8_t lower, int part) {
  return static_cast<std::uint8_t>((upper * (256 - part) + lower * part + 128) >> 8);
}

/// Grey level of the right image where a point of row v of the left one is seen in column u. Above and below the image
/// its first and last row are repeated.
STEREOGRID_HD inline std::uint8_t aligned_pixel(View<const std::uint8_t> right, int u, int v, const OffsetRow& row) {
  const int place{v * 256 + row.at(u)};
  const auto clamped = [&](int at) { return at < 0 ? 0 : (at > right.height - 1 ? right.height - 1 : at); };
  return between_rows(right(u, clamped(place >> 8)), right(u, clamped((place >> 8) + 1)), place & 255);
}

}  // namespace stereogrid
