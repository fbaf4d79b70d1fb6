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

/// Standard deviations of a road plane.
struct PlaneSigmas {
  double height_m;
  double pitch_rad;
  double roll_rad;
};

/// How well a plane is known: one that was fitted in this frame, or one that is only predicted.
PlaneSigmas plane_sigmas(const Ground& ground);

/// Disparities of pixels that belong to the road lie within low … high.
struct RoadBand {
  double low;
  double high;
};

/// A point at height h above a plane that has disparity d_r at its pixel has d = d_r + d·h/H. Within the band are the
/// heights up to ± given_height_m, and what is within two standard deviations of the plane: noise of the disparity, and
/// the plane's own, σ² = given_sigma_px² + (d_r σ_H/H)² + (b/H)² ((f σ_pitch)² + ((u − u0) σ_roll)²).
RoadBand road_band(const Rig& rig, double ground_height_m, const PlaneSigmas& sigmas, const MatchingConfig& config,
                   double u, double road_disparity);

/// Splits `disparity` (px, ≤ 0 = none): above the band obstacle, within it road, below it (under the road: wrong)
/// nothing; nothing too below 0.5 px and beyond the bins of the u-disparity plane.
void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches);
void split(Reference& reference, View<const float> disparity, const Rig& rig, const Ground& ground,
           const MatchingConfig& config, Matches& matches);

/// Before any plane is known: every usable disparity counts as obstacle.
void leave_whole(View<const float> disparity, const MatchingConfig& config, Matches& matches);

}  // namespace stereogrid
