// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>

#include "clamped_to_int.hpp"
#include "motion/scaled_patch.hpp"

namespace stereogrid {

inline int rounded(float value) {
  return clamped_to_int(std::round(value));
}

inline bool holds_patch(const View<const std::uint8_t>& image, int u, int v) {
  return u >= patch_reach_u && u + patch_reach_u <= image.width && v >= patch_reach_v &&
         v + patch_reach_v < image.height;
}

// Sum of absolute differences of two patches.
inline int difference(const View<const std::uint8_t>& first, int u1, int v1, const View<const std::uint8_t>& second,
                      int u2, int v2) {
  int sum{0};
  for (int j{-patch_reach_v}; j <= patch_reach_v; ++j) {
    const std::uint8_t* a{first.row(v1 + j) + u1 - patch_reach_u};
    const std::uint8_t* b{second.row(v2 + j) + u2 - patch_reach_u};
    for (int i{0}; i < patch_columns; ++i) sum += std::abs(a[i] - b[i]);
  }
  return sum;
}

// Place around `expected` at which the patch fits best and clearly better than elsewhere, to two pixels.
inline std::optional<Place> searched(const ScaledPatch& patch, const View<const std::uint8_t>& image, Place expected,
                                     int columns, int rows) {
  // A place counts as found if no other one, further away than this, fits nearly as well.
  constexpr int same_place_px{4};
  constexpr double clearly_best{0.8};
  int best{std::numeric_limits<int>::max()};
  int other{best};
  Place place;
  int best_u{0};
  for (int v{rounded(expected.v) - rows}; v <= rounded(expected.v) + rows; v += 2) {
    for (int u{rounded(expected.u) - columns}; u <= rounded(expected.u) + columns; u += 2) {
      if (!holds_patch(image, u, v)) continue;
      const int now{difference(patch.grey(), ScaledPatch::centre_u, ScaledPatch::centre_v, image, u, v)};
      const bool is_elsewhere{std::abs(u - best_u) > same_place_px};
      if (now < best) {
        if (is_elsewhere) other = best;
        best = now;
        best_u = u;
        place = {static_cast<float>(u), static_cast<float>(v)};
      } else if (is_elsewhere && now < other) {
        other = now;
      }
    }
  }
  if (best > clearly_best * other) return std::nullopt;
  return place;
}

}  // namespace stereogrid
