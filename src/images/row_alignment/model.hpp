// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clamped_to_int.hpp"
#include "host_device.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Terms of RowOffsets.
constexpr std::size_t row_terms{5};
using RowTerms = std::array<double, row_terms>;

/// Vertical misalignment: rows by which a point is lower in the right image than in the left one, as a function of its
/// place in the right image. Caused by slight errors of rotation and lenses in the rectification. terms · (1, x, y,
/// x·y, x²) with x = (u − u0)/400 and y = (v − v0)/100: pitch, roll, scale, yaw, lens.
struct RowOffsets {
  RowTerms terms{};  ///< px
  double cx_px{0};
  double cy_px{0};

  [[nodiscard]] STEREOGRID_HD RowTerms basis(double u, double v) const {
    const double x{(u - cx_px) / 400};
    const double y{(v - cy_px) / 100};
    return {1, x, y, x * y, x * x};
  }

  [[nodiscard]] STEREOGRID_HD double at(double u, double v) const {
    const RowTerms factors{basis(u, v)};
    double sum{0};
    for (std::size_t i{0}; i < row_terms; ++i) sum += terms[i] * factors[i];
    return sum;
  }
};

/// Number of columns that share the offset of their centre; it changes by some hundredths of a pixel across them.
constexpr int offset_columns{16};

/// Row of the right image, in column u, for a point of row v of the left image, in 1/256 px. An integer, so that every
/// back end interpolates alike; offsets beyond ±4096 px are cut off.
STEREOGRID_HD inline int place_256(const RowOffsets& offsets, int u, int v) {
  const double offset{offsets.at(u / offset_columns * offset_columns + offset_columns / 2, v) * 256};
  constexpr int limit{4096 * 256};
  return v * 256 + clamped_to_int(offset < 0 ? offset - 0.5 : offset + 0.5, limit);
}

/// Grey level between two rows, `part` / 256 below the upper one.
STEREOGRID_HD inline std::uint8_t between_rows(std::uint8_t upper, std::uint8_t lower, int part) {
  // at most 255·256 + 128: fits
  return static_cast<std::uint8_t>(static_cast<std::uint16_t>(upper * (256 - part) + lower * part + 128) >> 8);
}

}  // namespace stereogrid
