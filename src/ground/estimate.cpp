// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/fit.hpp"

namespace stereogrid {

Ground estimate_ground(const Rig& rig, const GroundConfig& config, View<const float> road_disparity,
                       const Ground& previous, double dt_s, GroundSpace& space) {
  if (!config.estimate) {
    Ground trusted{previous};
    trusted.estimated = false;
    return trusted;
  }
  const Ground before{predicted(rig, config, previous, dt_s)};
  space.samples.clear();
  add_samples(road_disparity, first_ground_row(rig, road_plane(rig, before)), space.samples);
  return fit_ground(rig, config, before, space);
}

Ground fit_ground(const Rig& rig, const GroundConfig& config, const Ground& before, GroundSpace& space) {
  const RoadPlane expected{road_plane(rig, before)};
  const Matrix3 covariance{carried(numbers_by_ground(rig, before), covariance_of(before))};
  RoadPlane plane{expected};
  const double radius_px{refine(space.samples, covariance, plane)};
  PlaneMeasurement measurement;
  if (radius_px == 0 || !measure(plane, radius_px, space, measurement)) return before;
  return updated(rig, config, before, expected, covariance, measurement);
}

}  // namespace stereogrid
