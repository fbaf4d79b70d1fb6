// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/matrix3.hpp"
#include "geometry/road_plane.hpp"
#include "memory_bytes.hpp"
#include "numbers.hpp"

namespace stereogrid {

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

/// Disparities of a frame at lattice pixels, of either hypothesis, in the order of their rows.
struct PlaneSamples {
  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(x, y, disparity, weight, fit_weight); }
  void reserve(std::size_t count);
  void resize(std::size_t count);
  void clear() { resize(0); }

  std::vector<float> x;           ///< u − cx_px
  std::vector<float> y;           ///< v − cy_px
  std::vector<float> disparity;   ///< px
  std::vector<float> weight;      ///< part of an independent observation; a block of 32 × 32 px is one
  std::vector<float> fit_weight;  ///< weight in the fit around an expected plane: less for samples matched as upright
  float first_x{0};               ///< left border of the image, less cx_px
  float last_x{0};                ///< right border
  float last_y{0};                ///< lowest row that can have samples, less cy_px
  float disparities{0};           ///< number of disparities searched
  float noise_px{0.5F};           ///< standard deviation of disparities on ground
};

/// Side of a square whose samples are one independent observation: errors of neighbours are alike, on one thing and
/// within a window of the matcher.
inline int block_px(const Rig& rig) {
  return std::clamp(rig.width_px / 20, 12, 32);
}

/// Number of such squares in the image, whole or not.
inline std::size_t blocks_of(const Rig& rig) {
  const int side{block_px(rig)};
  return static_cast<std::size_t>(rig.width_px / side + 1) * static_cast<std::size_t>(rig.height_px / side + 1);
}

/// Sets PlaneSamples::weight of samples at pixels. `spacing_px`: distance of neighbouring samples in rows and columns.
/// `blocks`: scratch of blocks_of(rig).
void weigh(const Rig& rig, double spacing_px, std::vector<float>& blocks, PlaneSamples& samples);

/// A plane as the evidence needs it: its disparities are those of RoadPlane.
struct PlaneHypothesis {
  PlaneHypothesis() = default;
  PlaneHypothesis(const RoadPlane& plane, const Rig& rig, const PlaneSamples& samples);

  [[nodiscard]] float expected(float x, float y) const { return at_centre + per_u * x + per_v * y; }

  float at_centre{0};
  float per_u{0};
  float per_v{0};
  float flatness{0.02F};  ///< unevenness of ground, share of the disparity: roads are cambered
  float noise_px{0.5F};   ///< standard deviation of the matcher's disparities on ground
  float near_px{1};       ///< largest disparity in view that can be matched
  float per_path_px{0};   ///< expected disparity at the border of the vehicle's path, per px from the image's centre
};

/// Smallest expected disparity of ground whose distance is known well enough to distinguish planes, px.
constexpr float ground_px_min{1.5F};

/// Sums of a plane's addends over all samples: partial sums of plane_block samples, each of plane_lanes floats that are
/// added by halves, are added in their order. The same on every machine, and with any number of threads.
constexpr std::size_t plane_block{256};
constexpr std::size_t plane_lanes{8};
constexpr std::size_t support_sums{8};
constexpr std::size_t equation_sums{9};
constexpr int share_bins{256};
constexpr int share_parts{1 << 24};
constexpr float deviation_max_px{2};

#include "ground/plane_formulas.hpp"

template <std::size_t count>
struct PlaneSums {
  std::array<double, count> sums{};
  std::array<std::uint64_t, share_bins> bins{};
};

PlaneSums<support_sums> sum_support(const PlaneHypothesis& plane, const PlaneSamples& samples);
PlaneSums<equation_sums> sum_equations(const PlaneHypothesis& plane, const PlaneSamples& samples,
                                       std::span<const float> weights);

/// The same in plain loops: the definition.
namespace plain {
PlaneSums<support_sums> sum_support(const PlaneHypothesis& plane, const PlaneSamples& samples);
PlaneSums<equation_sums> sum_equations(const PlaneHypothesis& plane, const PlaneSamples& samples,
                                       std::span<const float> weights);
}  // namespace plain

/// Evidence of a plane, without prior, in nats, and what it rests on. Counts are sums of weights.
struct PlaneSupport {
  double evidence{0};
  double near_evidence{0};  ///< part from the nearest half of the view
  double on{0};
  double below{0};
  double near_all{0};     ///< samples in the nearest half of the view: at least half of the largest disparity
  double near_on{0};      ///< samples among them on the plane
  double ring_all{0};     ///< samples of the nearest ground: at least 0.7 of the largest disparity
  double ring_on{0};      ///< samples among them on the plane
  double depth_ratio{1};  ///< 90th percentile of the expected disparities on the plane, relative to the 10th

  [[nodiscard]] double near_share() const { return near_all > 0 ? near_on / near_all : 0; }
};

PlaneSupport support_of(const PlaneHypothesis& plane, const PlaneSamples& samples);

/// Evidence of p less that of q over the nearest samples, of at least 0.6 of the largest disparity that either expects
/// in view. Nats.
double ring_margin(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples);

/// True where p and q cannot both be the ground: they differ by more than 3 σ of a sample over most of the nearest 60 %
/// of the view.
bool are_in_conflict(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples);

/// Normal equations of the samples on a plane, weighted by the probability that they are; complete. Units of
/// numbers_of(RoadPlane). `weights`: of PlaneSamples.
struct PlaneEquations {
  Matrix3 matrix{};
  Vector3 vector{};
  float deviation_px{0};  ///< median distance of the samples around the plane
};
PlaneEquations equations_of(const PlaneHypothesis& plane, const PlaneSamples& samples, std::span<const float> weights);

}  // namespace stereogrid
