// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "ground/model.hpp"
#include "host_device.hpp"
#include "matching/matching.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Matches from external disparities. They have one hypothesis only, so the height above the ground plane separates
/// road and obstacles.

/// Tests whether a disparity d is above or below the road with disparity r at the pixel. A point at height h above a
/// plane at distance H has d = r·H/(H − h). Both need heights beyond ± road_height_m, and a difference d − r beyond two
/// standard deviations: noise of the disparity, and the plane's own, σ² = external_sigma_px² + (r σ_H/H)² + (b/H)² ((f
/// σ_pitch)² + (x σ_roll)²) with x = u − u0.
struct HeightTest {
  static constexpr float never{std::numeric_limits<float>::infinity()};

  STEREOGRID_HD HeightTest(const Rig& rig, const Ground& ground, const MatchingConfig& config);

  [[nodiscard]] STEREOGRID_HD float margin2(float r, float x) const {
    return constant + per_r2 * (r * r) + per_x2 * (x * x);
  }
  [[nodiscard]] STEREOGRID_HD bool is_above(float d, float r, float x) const {
    return d > r && d > r * above && (d - r) * (d - r) > margin2(r, x);
  }
  [[nodiscard]] STEREOGRID_HD bool is_below(float d, float r, float x) const {
    return d < r * below && (d - r) * (d - r) > margin2(r, x);
  }

  float constant;  ///< constant part of margin², px²
  float per_r2;
  float per_x2;
  float above;  ///< d/r at the height road_height_m
  float below;
};

STEREOGRID_HD inline HeightTest::HeightTest(const Rig& rig, const Ground& ground, const MatchingConfig& config) {
  constexpr double significance{2};      // standard deviations
  constexpr double road_height_m{0.15};  // lower above the plane is road
  const auto squared = [](double deviation) {
    return static_cast<float>(significance * deviation * significance * deviation);
  };
  const double scale{rig.baseline_m / ground.height_m};
  const double share{road_height_m / ground.height_m};
  constant = squared(config.external_sigma_px) + squared(scale * rig.focal_px * ground.pitch_sigma_rad);
  per_r2 = squared(ground.height_sigma_m / ground.height_m);
  per_x2 = squared(scale * ground.roll_sigma_rad);
  above = share < 1 ? static_cast<float>(1 / (1 - share)) : never;
  below = static_cast<float>(1 / (1 + share));
}

/// Bin 0 is "no measurement", and the u-disparity plane ends.
STEREOGRID_HD inline bool is_usable(float disparity, int disparities) {
  return disparity >= 0.5f && disparity < static_cast<float>(disparities) - 0.5f;
}

/// `Matches` of an external disparity.
struct SplitDisparity {
  float obstacle;
  float road;
};

/// One row of `split`.
struct SplitRow {
  STEREOGRID_HD SplitRow(const RoadPlane& plane, int v)
      : centre_u{static_cast<float>(plane.cx_px)},
        per_u{static_cast<float>(plane.per_u)},
        at_centre{static_cast<float>(plane.disparity(plane.cx_px, v))} {}

  [[nodiscard]] STEREOGRID_HD SplitDisparity at(int u, float d, const HeightTest& test, int disparities) const {
    const float x{static_cast<float>(u) - centre_u};
    const float r{at_centre + per_u * x};
    const bool usable{is_usable(d, disparities)};
    const bool above{test.is_above(d, r, x)};
    return {usable && above ? d : 0.0f, usable && !above && !test.is_below(d, r, x) ? d : 0.0f};
  }

  float centre_u;
  float per_u;
  float at_centre;
};

/// Splits `disparity` (px, ≤ 0 = none). Above the road: obstacle; below it: wrong and left out; the rest: road.
/// Disparities below 0.5 px or beyond the bins of the u-disparity plane are left out, too.
void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches);
void split(Reference& reference, View<const float> disparity, const Rig& rig, const Ground& ground,
           const MatchingConfig& config, Matches& matches);

/// Before any plane is known: every usable disparity counts as obstacle.
void leave_whole(View<const float> disparity, const MatchingConfig& config, Matches& matches);

}  // namespace stereogrid
