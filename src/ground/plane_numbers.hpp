// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "geometry/matrix3.hpp"
#include "geometry/road_plane.hpp"

namespace stereogrid {

/// Disparity of a pixel of MatchLattice.
struct GroundSample {
  float u;
  float v;
  float disparity;
};

/// Minimum number of samples of a road.
constexpr int ground_samples_min{100};

STEREOGRID_HD constexpr double radians(double degrees) {
  return degrees * 3.14159265358979323846 / 180;
}

// A plane's three numbers, at_centre in px, per_u and per_v in px per 100 px, are of like size.

STEREOGRID_HD inline Vector3 numbers_of(const RoadPlane& plane) {
  return {{plane.at_centre, 100 * plane.per_u, 100 * plane.per_v}};
}

STEREOGRID_HD inline Matrix3 numbers_by_ground(const Rig& rig, const Ground& ground) {
  return diagonal({{1, 100, 100}}) * plane_by_ground(rig, ground);
}

STEREOGRID_HD inline void move(RoadPlane& plane, const Vector3& numbers) {
  plane.at_centre += numbers[0];
  plane.per_u += numbers[1] / 100;
  plane.per_v += numbers[2] / 100;
}

/// Estimate of a plane's numbers from the samples alone.
struct PlaneMeasurement {
  Vector3 numbers{};
  Matrix3 covariance{};
};

/// Covariance of errors common to all pixels of a frame: kerbs and the feet of obstacles classified as road, mostly far
/// away. Source: the synthetic sets, whose plane is exact.
STEREOGRID_HD inline Matrix3 common_errors() {
  constexpr double common_px[3]{0.03, 0.004, 0.02};  // px and px per 100 px
  return diagonal({{common_px[0] * common_px[0], common_px[1] * common_px[1], common_px[2] * common_px[2]}});
}

STEREOGRID_HD inline double to_whole(double value, double steps) {
  return std::floor(value * steps + 0.5) / steps;
}

/// Height, angles and their standard deviations in whole 2⁻²⁰ m and rad, correlations in whole 2⁻¹². Back ends with
/// another order of summation then nearly always give the same ground, and the same matches, to the bit.
STEREOGRID_HD inline Ground rounded(Ground ground) {
  constexpr double lengths{1 << 20};
  constexpr double correlations{1 << 12};
  ground.height_m = to_whole(ground.height_m, lengths);
  ground.pitch_rad = to_whole(ground.pitch_rad, lengths);
  ground.roll_rad = to_whole(ground.roll_rad, lengths);
  ground.height_sigma_m = to_whole(ground.height_sigma_m, lengths);
  ground.pitch_sigma_rad = to_whole(ground.pitch_sigma_rad, lengths);
  ground.roll_sigma_rad = to_whole(ground.roll_sigma_rad, lengths);
  // less by one step in all: the covariance remains positive definite
  constexpr double shrunk{1 - 1 / correlations};
  ground.height_pitch_correlation = to_whole(shrunk * ground.height_pitch_correlation, correlations);
  ground.height_roll_correlation = to_whole(shrunk * ground.height_roll_correlation, correlations);
  ground.pitch_roll_correlation = to_whole(shrunk * ground.pitch_roll_correlation, correlations);
  return ground;
}

/// Correlation time of the suspension and of the road's slope under the vehicle.
constexpr double correlated_s{5};

/// Covariance of (height, pitch, roll) of a frame's plane relative to the extrinsics: what the suspension does.
inline Matrix3 suspension(const Ground& extrinsics) {
  const double height_m{0.02 * extrinsics.height_m};
  constexpr double pitch_rad{radians(0.5)};
  constexpr double roll_rad{radians(0.7)};
  return diagonal({{height_m * height_m, pitch_rad * pitch_rad, roll_rad * roll_rad}});
}

inline Vector3 difference(const Ground& a, const Ground& b) {
  return {a.height_m - b.height_m, a.pitch_rad - b.pitch_rad, a.roll_rad - b.roll_rad};
}

/// The Kalman filter's step: `before` with `covariance`, measured as `seen` with `noise`.
inline Ground fused(const Ground& before, const Matrix3& covariance, const Ground& seen, const Matrix3& noise) {
  const Matrix3 gain{covariance * inverse(covariance + noise)};
  const Vector3 step{gain * difference(seen, before)};
  const Matrix3 rest{diagonal({{1, 1, 1}}) + scaled(-1, gain)};
  Ground after{before};
  after.height_m += step[0];
  after.pitch_rad += step[1];
  after.roll_rad += step[2];
  return with_covariance(after, carried(rest, covariance) + carried(gain, noise));
}

}  // namespace stereogrid
