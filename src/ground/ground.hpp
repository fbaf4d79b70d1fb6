// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "ground/fit_model.hpp"
#include "held_bytes.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

struct GroundSample {
  float u;
  float v;
  float disparity;
};

struct GroundSpace {
  GroundSpace(int width, int height);

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(samples, scores); }

  std::vector<GroundSample> samples;
  std::vector<Vector3> scores;  ///< one per block of the image
  int blocks_across{0};
};

/// Road plane through the matches of a frame.
struct PlaneFit {
  Ground plane;
  bool is_lost{false};  ///< the matches put the road outside the gate around the plane of the frame before
};

/// Road plane of this frame: a Kalman filter's step from `previous` (dt_s ago) with the plane through this frame's road
/// disparities. Where too little road is seen or the result leaves the gates: `predicted`, `estimated` false. One
/// implementation serves every back end on the CPU: it reads a lattice of some thousand pixels.
Ground estimate_ground(const Rig& rig, const GroundConfig& config, View<const float> road_disparity,
                       const Ground& previous, double dt_s, GroundSpace& space);

/// True where clearly more pixels lie on a plane of another pitch than on this one. Both images are read, since road
/// outside the range of the road hypothesis is matched as upright.
bool is_lost(const Rig& rig, const GroundConfig& config, View<const float> obstacle_disparity,
             View<const float> road_disparity, const Ground& ground, GroundSpace& space);

/// Road plane anywhere within the gates, whatever `previous` is: RANSAC over lines in v-disparity (docs/method.md §4.5;
/// Labayrade 2002) and planes through three pixels, of both hypotheses. A found plane has
/// the covariance of calibrated_ground. `previous` with `estimated` false: none found.
Ground search_ground(const Rig& rig, const GroundConfig& config, View<const float> obstacle_disparity,
                     View<const float> road_disparity, const Ground& previous, GroundSpace& space);

/// True where another plane has 1.5 times the samples of `plane`, and at least `least`. Candidates: 0.2 to 4 m below
/// the camera, pitch −20° to 35°, roll up to 10°.
bool has_better_plane(const Rig& rig, const std::vector<GroundSample>& samples, int least, const RoadPlane& plane);

}  // namespace stereogrid
