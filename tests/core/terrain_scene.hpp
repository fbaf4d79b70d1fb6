// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::test {

/// Elevation of the ground at (x ahead, y left), m.
using HeightField = std::function<float(float x, float y)>;

/// Disparities of a height field as a level camera sees it: of the first point of each ray below the surface.
inline Image<float> disparity_of(const Rig& rig, const HeightField& height) {
  constexpr float step_m{0.005f};
  constexpr float farthest_m{40};
  Image<float> disparity{rig.width_px, rig.height_px};
  const auto f = static_cast<float>(rig.focal_px);
  for (int u{0}; u < rig.width_px; ++u) {
    const float across{(static_cast<float>(rig.cx_px) - static_cast<float>(u)) / f};
    float x{0.1f};
    for (int v{rig.height_px - 1}; v >= 0; --v) {
      const float tangent{(static_cast<float>(v) - static_cast<float>(rig.cy_px)) / f};
      const auto is_over = [&] {
        return static_cast<float>(rig.camera_height_m) - tangent * x > height(x, across * x);
      };
      while (x < farthest_m && is_over()) x += step_m;
      if (x >= farthest_m) break;
      disparity(u, v) = f * static_cast<float>(rig.baseline_m) / x;
    }
  }
  return disparity;
}

/// Errors of a stereo matcher: noise of `sigma_px` that is correlated over five pixels, 3 % outliers, 12 % holes.
inline void add_errors(float sigma_px, std::uint32_t seed, Image<float>& disparity) {
  std::mt19937 random{seed};
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  // the sum of twelve uniform numbers is normal enough, and the same with every standard library
  const auto normal = [&] {
    float sum{-6};
    for (int i{0}; i < 12; ++i) sum += uniform();
    return sum;
  };
  const auto smooth = [&] {
    Image<float> white{disparity.width() + 4, disparity.height() + 4};
    for (float& one : white) one = normal() / 5;
    Image<float> sums{disparity.width(), disparity.height()};
    for (const auto [u, v] : raster(sums)) {
      for (int j{0}; j < 5; ++j) {
        for (int i{0}; i < 5; ++i) sums(u, v) += white(u + i, v + j);
      }
    }
    return sums;
  };
  const Image<float> noise{smooth()};
  const Image<float> holes{smooth()};
  for (std::size_t i{0}; i < disparity.size(); ++i) {
    float& d{disparity.data()[i]};
    if (!(d > 0)) continue;
    d = std::max(d + sigma_px * noise.data()[i], 0.05f);
    if (uniform() < 0.03f) d = 1 + 60 * uniform();
    if (holes.data()[i] > 1.175f) d = 0;
  }
}

}  // namespace stereogrid::test
