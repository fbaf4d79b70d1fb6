// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ground/ground.hpp"

namespace stereogrid {

/// Appends the pixels of a disparity image on a lattice, from the row `first_row` down.
void add_samples(View<const float> disparity, double first_row, std::vector<GroundSample>& samples);

inline double residual(const RoadPlane& plane, const GroundSample& sample) {
  return sample.disparity - plane.disparity(sample.u, sample.v);
}

/// Fits `plane` to the samples around it: Tukey's robust least squares, whose radius follows the median residual, with
/// the first `plane` and `covariance` as prior. Returns the radius; 0: the samples determine no plane.
double refine(std::span<const GroundSample> samples, const Matrix3& covariance, RoadPlane& plane);

struct PlaneDraws {
  int rounds{600};
  double inlier_px{1};  ///< largest distance of a sample on the plane
};

/// RANSAC from `plane`, which is replaced if another one within the gates has 1.5 times the samples, less those below.
/// True: the plane has enough samples for a road.
bool find_plane(const Rig& rig, const GroundConfig& config, const std::vector<GroundSample>& samples, RoadPlane& plane,
                const PlaneDraws& draws = {});

/// The Kalman filter's step from `before`, which the samples of `space` measure. `before`: they do not.
Ground fit_ground(const Rig& rig, const GroundConfig& config, const Ground& before, GroundSpace& space);

/// At `plane`, to which the samples have been refined with that radius: one more step without tether. The covariance
/// comes from how much the blocks of the image disagree (the sandwich of robust regression, by clusters), since errors
/// of neighbouring pixels are alike. False: not determined.
bool measure(const RoadPlane& plane, double radius_px, GroundSpace& space, PlaneMeasurement& measurement);

}  // namespace stereogrid
