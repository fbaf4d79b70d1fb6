// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ground/model.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// A pixel and its disparity.
struct GroundSample {
  float u;
  float v;
  float disparity;
};

/// Working memory of estimate_ground.
struct GroundSpace {
  GroundSpace(int width, int height);
  std::vector<GroundSample> samples;
};

/// Road plane of this frame from its road disparities: robust least squares around `previous`, gated by the calibrated
/// plane, blended with `previous`. Where too little road is seen or the fit leaves the gate: `previous`, `estimated`
/// false. One implementation serves every back end: it reads a lattice of some thousand pixels.
Ground estimate_ground(const Rig& rig, const GroundConfig& config, View<const float> road_disparity,
                       const Ground& previous, GroundSpace& space);

/// Road plane without trusting any earlier one beyond the gate: RANSAC over lines in v-disparity (eq. 1b; Labayrade
/// 2002) on the pixels of both hypotheses. Falls back to `calibrated`, `estimated` false.
Ground search_ground(const Rig& rig, const GroundConfig& config, View<const float> obstacle_disparity,
                     View<const float> road_disparity, const Ground& calibrated, GroundSpace& space);

}  // namespace stereogrid
