// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "host_device.hpp"

namespace stereogrid {

/// Half sizes of the census window: 9 columns × 7 rows.
constexpr int census_half_u{4};
constexpr int census_half_v{3};

/// Bits of a descriptor: half of the 63 window pixels, each compared with its mirror image in the centre.
constexpr int census_bits{31};

/// Centre-symmetric census: bit k tells whether the k-th pixel of the window's first half is darker than its mirror
/// image. Gain and offset of the camera do not change it. `pixel(i, j)` is the grey level at column offset i and row
/// offset j.
template <class Pixel>
STEREOGRID_HD inline std::uint32_t census(const Pixel& pixel) {
  std::uint32_t bits{0};
  for (int j{-census_half_v}; j <= 0; ++j) {
    const int last{j < 0 ? census_half_u : -1};
    for (int i{-census_half_u}; i <= last; ++i) bits = bits << 1 | (pixel(i, j) < pixel(-i, -j) ? 1u : 0u);
  }
  return bits;
}

/// Where the road hypothesis looks in the right image: 1/256 px, so that every back end interpolates alike.
constexpr int shear_steps{256};

STEREOGRID_HD inline int shear_of(double road_disparity_px) {
  const double scaled{road_disparity_px * shear_steps};
  return static_cast<int>(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
}

/// Grey level of the right image seen at u − shear, interpolated between its neighbours; the border pixel is repeated.
STEREOGRID_HD inline std::uint8_t sheared(const std::uint8_t* right_row, int width, int u, int shear) {
  const int position{u * shear_steps - shear};
  const int below{position >= 0 ? position / shear_steps : -((-position + shear_steps - 1) / shear_steps)};
  const int part{position - below * shear_steps};
  const int a{below < 0 ? 0 : (below >= width ? width - 1 : below)};
  const int b{below + 1 < 0 ? 0 : (below + 1 >= width ? width - 1 : below + 1)};
  return static_cast<std::uint8_t>((right_row[a] * (shear_steps - part) + right_row[b] * part + shear_steps / 2) /
                                   shear_steps);
}

/// Sub-pixel place of a cost curve's minimum between the integers, from the costs one step before, at and after it: the
/// equiangular fit of Shimizu and Okutomi, made for costs that rise linearly. Within ±0.49, so that rounding gives the
/// integer back.
STEREOGRID_HD inline float subpixel_offset(int before, int at, int after) {
  const int rise{(before > after ? before : after) - at};
  if (rise <= 0) return 0.0f;
  const float offset{static_cast<float>(before - after) / static_cast<float>(2 * rise)};
  return offset < -0.49f ? -0.49f : (offset > 0.49f ? 0.49f : offset);
}

/// What one hypothesis found at a pixel.
struct Candidate {
  std::uint16_t cost;       ///< of the best shift
  std::uint16_t runner_up;  ///< smallest cost more than one step away from the best; 65535: none
  std::int16_t shift;       ///< best shift in px
  bool consistent;          ///< right-to-left matching agrees
  float offset;             ///< sub-pixel correction of `shift`
};

/// Is the minimum clear? Every shift but its neighbours must cost more by the share `uniqueness`, given in 1/1024.
STEREOGRID_HD inline bool is_unique(int cost, int runner_up, int uniqueness_1024) {
  return runner_up * 1024 >= cost * (1024 + uniqueness_1024) && runner_up > cost;
}

}  // namespace stereogrid
