// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid {

/// Minimum number of samples of a road.
constexpr int ground_samples_min{100};

/// Spacing of the samples along rows and columns, in pixels; the first is at half of it.
constexpr int lattice_px{4};
/// Errors of pixels within a block are taken as one error, those of different blocks as independent.
constexpr int block_u_px{96};
constexpr int block_v_px{32};

STEREOGRID_HD inline double clamped(double value, double low, double high) {
  const double raised{value < low ? low : value};
  return raised > high ? high : raised;
}

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

/// First image row whose road disparities are used. Farther away they are a few px, and objects on the road have as
/// many samples as the road.
STEREOGRID_HD inline double first_ground_row(const Rig& rig, const RoadPlane& plane) {
  constexpr double nearest_px{4};
  const double at_bottom{plane.disparity(rig.cx_px, rig.height_px)};
  const double from{at_bottom / 4 < nearest_px ? at_bottom / 4 : nearest_px};
  return rig.height_px - (at_bottom - from) / plane.per_v;
}

/// First lattice row at or before an image row.
STEREOGRID_HD inline int lattice_row(double first_row, int height) {
  return clamped_to_int(clamped(first_row, 0, height)) / lattice_px;
}

/// Tukey's weight is (1 − t)² with t = (r/radius)², below 1.
template <class Real>
STEREOGRID_HD inline Real square_of_share(Real r, Real radius_px) {
  return r * r / (radius_px * radius_px);
}

/// Sums of weighted least squares, whose rows are (1, u, v) in units of the plane's numbers.
struct NormalEquations {
  Matrix3 matrix{};
  Vector3 vector{};
  int inliers{0};

  // Without loops over `row`: g++ would store its numbers one by one and load two at once, which stalls.
  void add(const Vector3& row, double weight, double r) {
    const double x{row[0]};
    const double y{row[1]};
    const double z{row[2]};
    ++inliers;
    vector[0] += weight * r * x;
    vector[1] += weight * r * y;
    vector[2] += weight * r * z;
    matrix[0][0] += weight * x * x;
    matrix[1][0] += weight * y * x;
    matrix[1][1] += weight * y * y;
    matrix[2][0] += weight * z * x;
    matrix[2][1] += weight * z * y;
    matrix[2][2] += weight * z * z;
  }
  STEREOGRID_HD void complete() {
    for (int i{0}; i < 3; ++i) {
      for (int j{i + 1}; j < 3; ++j) matrix[i][j] = matrix[j][i];
    }
  }
};

/// Bins per px of the residuals' histogram, for their median.
constexpr int residual_bins_per_px{25};
constexpr int residual_bins{50};

/// Radius beyond which samples have no weight, from the bin of the median residual.
STEREOGRID_HD inline double radius_of_bin(int median) {
  constexpr double medians{4};
  constexpr double least_px{0.4};
  constexpr double most_px{2.5};
  return clamped(medians * (median + 0.5) / residual_bins_per_px, least_px, most_px);
}

/// Bin of the median residual. `count_of(bin)`.
template <class CountOf>
STEREOGRID_HD inline int median_bin(const CountOf& count_of, int total) {
  int median{0};
  int below{count_of(0)};
  while (median + 1 < residual_bins && 2 * below < total) below += count_of(++median);
  return median;
}

/// Schedule of the robust fit: wide rounds first, then rounds until it settles. Several planes fit a part of a cambered
/// road each; the result must not depend on the start.
constexpr int fit_rounds_max{12};
constexpr int wide_rounds{2};
STEREOGRID_HD constexpr double wide_radius_px(int round) {
  return round == 0 ? 4 : 2.5;
}
STEREOGRID_HD inline bool has_settled(int round, double largest_step) {
  constexpr double settled_px{0.002};
  return round > wide_rounds && largest_step < settled_px;
}

/// Prior of the fit, for directions that the samples do not determine: inverse of the numbers' covariance, times the
/// variance of one pixel.
STEREOGRID_HD inline Matrix3 tether_of(const Matrix3& covariance) {
  constexpr double pixel_variance{9};  // px²
  return scaled(pixel_variance, inverse(covariance));
}

/// A step of the fit, tethered to the numbers `start`; its largest part, or below 0: no plane.
STEREOGRID_HD inline double fit_step(const NormalEquations& equations, const Matrix3& tether, const Vector3& start,
                                     RoadPlane& plane) {
  if (equations.inliers < ground_samples_min) return -1;
  const Vector3 pull{tether * (numbers_of(plane) - start)};
  const Vector3 step{inverse(equations.matrix + tether) * (equations.vector - pull)};
  move(plane, step);
  if (!(plane.per_v > 0)) return -1;
  double most{0};
  for (int i{0}; i < 3; ++i) most = std::abs(step[i]) > most ? std::abs(step[i]) : most;
  return most;
}

/// Estimate of a plane's numbers from the samples alone.
struct PlaneMeasurement {
  Vector3 numbers{};
  Matrix3 covariance{};
};

/// Sums over the samples at the plane that the fit has ended at.
struct FitSums {
  NormalEquations equations;  ///< complete
  double weights{0};
  double slopes{0};  ///< sum of the slopes of weight·r
  Matrix3 spread{};  ///< squares of the blocks' shares of `equations.vector`
  int blocks{0};     ///< blocks with samples
};

/// False: not determined.
STEREOGRID_HD inline bool measured(const RoadPlane& plane, const FitSums& sums, PlaneMeasurement& measurement) {
  // Standard deviations, in px and px per 100 px, of errors common to all pixels of a frame: kerbs and the feet of
  // obstacles classified as road, mostly far away. Source: the synthetic sets, whose plane is exact.
  constexpr double common_px[3]{0.03, 0.004, 0.02};
  const NormalEquations& equations{sums.equations};
  if (equations.inliers < ground_samples_min || sums.blocks < 4 || !is_positive_definite(equations.matrix)) {
    return false;
  }
  const Matrix3 step{inverse(equations.matrix)};
  // Residuals that are spread evenly over the radius (slopes near 0) determine the plane poorly.
  const double sharpness{clamped(sums.slopes / sums.weights, 0.3, 1.0)};
  measurement.numbers = numbers_of(plane) + step * equations.vector;
  measurement.covariance =
      scaled(sums.blocks / ((sums.blocks - 3.0) * sharpness * sharpness), carried(step, sums.spread)) +
      diagonal({{common_px[0] * common_px[0], common_px[1] * common_px[1], common_px[2] * common_px[2]}});
  return true;
}

/// True within the gates around the calibration.
STEREOGRID_HD inline bool is_within_gates(const Rig& rig, const GroundConfig& config, const Ground& ground) {
  return std::abs(ground.height_m - rig.camera_height_m) <= config.height_gate_m &&
         std::abs(ground.pitch_rad - rig.camera_pitch_rad) <= radians(config.pitch_gate_deg) &&
         std::abs(ground.roll_rad - rig.camera_roll_rad) <= radians(config.roll_gate_deg);
}

/// Plane of the calibration. Standard deviation: a quarter of the gates; 0 where nothing is estimated.
STEREOGRID_HD inline Ground calibrated_ground(const Rig& rig, const GroundConfig& config) {
  constexpr double gate_sigmas{4};  // gates in standard deviations
  Ground ground{rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad, false};
  if (!config.estimate) return ground;
  ground.height_sigma_m = config.height_gate_m / gate_sigmas;
  ground.pitch_sigma_rad = radians(config.pitch_gate_deg) / gate_sigmas;
  ground.roll_sigma_rad = radians(config.roll_gate_deg) / gate_sigmas;
  return ground;
}

/// Random walk of the plane within a second (standard deviations): height in m, pitch and roll in rad.
constexpr double height_noise_m{0.03};
constexpr double pitch_noise_rad{radians(0.5)};
constexpr double roll_noise_rad{pitch_noise_rad};

/// A standard deviation that has grown for `dt_s`, to at most `most`.
STEREOGRID_HD inline double grown(double sigma, double noise, double dt_s, double most) {
  constexpr double least{1e-5};  // m, rad: gates may be 0, covariances must have an inverse
  const double sum{std::sqrt(sigma * sigma + noise * noise * dt_s)};
  const double bounded{most < sum ? most : sum};
  return bounded < least ? least : bounded;
}

/// `previous` after `dt_s` without a measurement: less certain, up to the uncertainty of the calibration.
STEREOGRID_HD inline Ground predicted(const Rig& rig, const GroundConfig& config, const Ground& previous, double dt_s) {
  const Ground widest{calibrated_ground(rig, config)};
  Ground ground{previous};
  ground.estimated = false;
  ground.height_sigma_m = grown(previous.height_sigma_m, height_noise_m, dt_s, widest.height_sigma_m);
  ground.pitch_sigma_rad = grown(previous.pitch_sigma_rad, pitch_noise_rad, dt_s, widest.pitch_sigma_rad);
  ground.roll_sigma_rad = grown(previous.roll_sigma_rad, roll_noise_rad, dt_s, widest.roll_sigma_rad);
  // added noise is independent: covariances stay, and correlations shrink
  const double height{clamped(previous.height_sigma_m / ground.height_sigma_m, 0, 1)};
  const double pitch{clamped(previous.pitch_sigma_rad / ground.pitch_sigma_rad, 0, 1)};
  const double roll{clamped(previous.roll_sigma_rad / ground.roll_sigma_rad, 0, 1)};
  ground.height_pitch_correlation *= height * pitch;
  ground.height_roll_correlation *= height * roll;
  ground.pitch_roll_correlation *= pitch * roll;
  return ground;
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

/// The Kalman filter's step from `before`, whose plane is `expected` with `covariance`; `before` where it leads out of
/// the gates.
STEREOGRID_HD inline Ground updated(const Rig& rig, const GroundConfig& config, const Ground& before,
                                    const RoadPlane& expected, const Matrix3& covariance,
                                    const PlaneMeasurement& measurement) {
  const Matrix3 gain{covariance * inverse(covariance + measurement.covariance)};
  RoadPlane plane{expected};
  move(plane, gain * (measurement.numbers - numbers_of(expected)));
  if (!(plane.per_v > 0)) return before;
  const Ground found{rounded(ground_of(rig, plane))};
  if (!is_within_gates(rig, config, found)) return before;
  const Matrix3 rest{diagonal({{1, 1, 1}}) + scaled(-1, gain)};
  // Joseph's form keeps it positive
  const Matrix3 after{carried(rest, covariance) + carried(gain, measurement.covariance)};
  return rounded(with_covariance(found, carried(inverse(numbers_by_ground(rig, found)), after)));
}

/// Pixels by their distance from a road plane, for is_lost: bins of half a px, the middle one from 0 on.
constexpr int distance_bins{128};
STEREOGRID_HD inline double distance_bin(double distance_px) {
  constexpr double bin_px{0.5};
  return distance_px / bin_px + distance_bins / 2.0;
}

/// Pixels in 2 px of distance, centred between the bins k − 1 and k.
template <class CountOf>
STEREOGRID_HD inline int share_around(const CountOf& count_of, int k) {
  return count_of(k - 2) + count_of(k - 1) + count_of(k) + count_of(k + 1);
}
STEREOGRID_HD inline bool is_near_the_plane(int k) {
  return k >= distance_bins / 2 - 2 && k <= distance_bins / 2 + 2;
}
STEREOGRID_HD inline bool lies_elsewhere(int here, int elsewhere) {
  return elsewhere >= ground_samples_min && 4 * elsewhere > 5 * here;
}

}  // namespace stereogrid
