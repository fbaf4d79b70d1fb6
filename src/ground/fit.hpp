// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "ground/ground.hpp"

namespace stereogrid {

/// Fewest samples that make a road.
constexpr std::size_t ground_samples_min{100};

/// Pixels of a disparity image on a lattice, from the row `first_row` down; appended.
void add_samples(View<const float> disparity, double first_row, std::vector<GroundSample>& samples);

inline double residual(const RoadPlane& plane, const GroundSample& sample) {
  return sample.disparity - plane.disparity(sample.u, sample.v);
}

// A plane's three numbers, at_centre in px, per_u and per_v in px per 100 px, are of like size.

Vector3 numbers_of(const RoadPlane& plane);
Matrix3 numbers_by_ground(const Rig& rig, const Ground& ground);
void move(RoadPlane& plane, const Vector3& numbers);

/// Moves `plane` to where the samples around it lie: Tukey's robust least squares, whose radius follows the median
/// residual, tethered to the first `plane` by the covariance of its numbers. Gives the radius; 0: the samples determine
/// no plane.
double refine(const std::vector<GroundSample>& samples, const Matrix3& covariance, RoadPlane& plane);

/// What the samples alone say of a plane's numbers.
struct PlaneMeasurement {
  Vector3 numbers{};
  Matrix3 covariance{};
};

/// At `plane`, to which the samples have been refined with that radius: one more step without tether. The covariance
/// comes from how much the blocks of the image disagree (the sandwich of robust regression, by clusters), since errors
/// of neighbouring pixels are alike. False: not determined.
bool measure(const RoadPlane& plane, double radius_px, GroundSpace& space, PlaneMeasurement& measurement);

}  // namespace stereogrid
