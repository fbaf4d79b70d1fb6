// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "stereogrid/image.hpp"

namespace stereogrid {

/// A point of an image, px.
struct Place {
  float u{0};
  float v{0};
};

/// A patch reaches from reach_u columns left to reach_u − 1 right of its place: a row is a whole number of vectors of
/// bytes.
constexpr int patch_reach_u{8};
constexpr int patch_reach_v{4};
constexpr int patch_columns{2 * patch_reach_u};
constexpr int patch_rows{2 * patch_reach_v + 1};
constexpr std::size_t patch_pixels{patch_columns * patch_rows};

using Patch = std::array<float, patch_pixels>;

/// A patch of an image, its mean grey level removed, and the normal equations of moving it over another image.
struct Template {
  Patch grey;
  Patch gradient_u;
  Patch gradient_v;  ///< along the columns of the other image
  double uu;
  double uv;
  double vv;
  double variance;
};

/// Cuts a patch out. With `shear`, the displacement's change per row, a column of the patch is slanted in the other
/// image. False where it is not inside.
bool cut(View<const std::uint8_t> image, Place place, float shear, Template& patch);

/// Squared gradient along one axis that a move along the other does not explain, grey levels² per pixel.
double information_u(const Template& patch);
double information_v(const Template& patch);

/// Limits of find().
struct FindLimits {
  int steps{3};
  double misfit{0.2};  ///< share of the patch's variance that may be left
};

/// Position of the patch in another image (Lucas and Kanade 1981, inverse compositional, Gauss-Newton; at most 0.7 px a
/// step, until a step is short). None if it leaves the image or does not fit.
std::optional<Place> find(View<const std::uint8_t> image, const Template& patch, float shear, Place start,
                          FindLimits limits = {});

/// The same in plain loops: the definition.
namespace plain {
bool cut(View<const std::uint8_t> image, Place place, float shear, Template& patch);
std::optional<Place> find(View<const std::uint8_t> image, const Template& patch, float shear, Place start,
                          FindLimits limits = {});
}  // namespace plain

/// The pixels of the left image whose disparities the host reads whatever back end found them; patches are cut around
/// them: (first_u + i·step_u, first_v + j·step_v).
struct MatchLattice {
  static constexpr int step_u{6};
  static constexpr int step_v{6};
  static constexpr int first_u{patch_reach_u + 1};
  static constexpr int first_v{patch_reach_v + 1};

  MatchLattice(int width, int height)
      : across{std::max(width - patch_reach_u - first_u + step_u - 1, 0) / step_u},
        down{std::max(height - patch_reach_v - 1 - first_v + step_v - 1, 0) / step_v} {}

  int across;
  int down;
};

/// Rows begin … end − 1 of an image, smoothed by the binomial of 3 × 3 pixels; the border repeats.
void smooth_rows(View<const std::uint8_t> image, int begin, int end, View<std::uint8_t> smoothed);

}  // namespace stereogrid
