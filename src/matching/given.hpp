// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ground/model.hpp"
#include "matching/matching.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Matches from a disparity image that somebody else has made. It has one hypothesis only, so road and obstacles are
/// told apart by their height above the road plane.

/// Is a disparity d above or below the road, whose disparity at the pixel is r? A point at height h above a plane at
/// distance H has d = r·H/(H − h). Both need heights beyond ± given_height_m, and a difference d − r beyond two
/// standard deviations: noise of the disparity, and the plane's own, σ² = given_sigma_px² + (r σ_H/H)² + (b/H)² ((f
/// σ_pitch)² + (x σ_roll)²) with x = u − u0.
struct HeightTest {
  HeightTest(const Rig& rig, const Ground& ground, const MatchingConfig& config);

  [[nodiscard]] float margin2(float r, float x) const { return constant + per_r2 * (r * r) + per_x2 * (x * x); }
  [[nodiscard]] bool is_above(float d, float r, float x) const {
    return d > r && d > r * above && (d - r) * (d - r) > margin2(r, x);
  }
  [[nodiscard]] bool is_below(float d, float r, float x) const {
    return d < r * below && (d - r) * (d - r) > margin2(r, x);
  }

  float constant;  ///< of margin², px²
  float per_r2;
  float per_x2;
  float above;  ///< d/r at the height given_height_m
  float below;
};

/// Splits `disparity` (px, ≤ 0 = none): what is above the road is obstacle, what is below it wrong and left out, the
/// rest road. Left out too is what is below 0.5 px or beyond the bins of the u-disparity plane.
void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches);
void split(Reference& reference, View<const float> disparity, const Rig& rig, const Ground& ground,
           const MatchingConfig& config, Matches& matches);

/// Before any plane is known: every usable disparity counts as obstacle.
void leave_whole(View<const float> disparity, const MatchingConfig& config, Matches& matches);

}  // namespace stereogrid
