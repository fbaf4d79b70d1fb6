// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "ground/fit.hpp"

namespace stereogrid {
namespace {

// How many standard deviations of the calibration the gates are away.
constexpr double gate_sigmas{4};

constexpr double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// Row from which on the road is read. Farther away, where it is only a few px, what stands on it weighs as much.
double first_row(const Rig& rig, const Ground& ground) {
  constexpr double nearest_px{4};
  const RoadPlane plane{road_plane(rig, ground)};
  const double at_bottom{plane.disparity(rig.centre_u_px, rig.height_px)};
  return rig.height_px - (at_bottom - std::min(nearest_px, at_bottom / 4)) / plane.per_v;
}

}  // namespace

Ground calibrated_ground(const Rig& rig, const GroundConfig& config) {
  Ground ground{rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad, false};
  if (!config.estimate) return ground;
  ground.height_sigma_m = config.height_gate_m / gate_sigmas;
  ground.pitch_sigma_rad = radians(config.pitch_gate_deg) / gate_sigmas;
  ground.roll_sigma_rad = radians(config.roll_gate_deg) / gate_sigmas;
  return ground;
}

bool is_believable(const Rig& rig, const GroundConfig& config, const Ground& ground) {
  return std::abs(ground.height_m - rig.camera_height_m) <= config.height_gate_m &&
         std::abs(ground.pitch_rad - rig.camera_pitch_rad) <= radians(config.pitch_gate_deg) &&
         std::abs(ground.roll_rad - rig.camera_roll_rad) <= radians(config.roll_gate_deg);
}

Ground predicted(const Rig& rig, const GroundConfig& config, const Ground& previous, double dt_s) {
  constexpr double least{1e-5};  // m, rad: gates may be 0, covariances must have an inverse
  const auto grown = [&](double sigma, double noise, double most) {
    return std::max(std::min(std::sqrt(sigma * sigma + noise * noise * dt_s), most), least);
  };
  const Ground widest{calibrated_ground(rig, config)};
  Ground ground{previous};
  ground.estimated = false;
  ground.height_sigma_m = grown(previous.height_sigma_m, config.height_noise_m, widest.height_sigma_m);
  ground.pitch_sigma_rad = grown(previous.pitch_sigma_rad, radians(config.pitch_noise_deg), widest.pitch_sigma_rad);
  ground.roll_sigma_rad = grown(previous.roll_sigma_rad, radians(config.roll_noise_deg), widest.roll_sigma_rad);
  // What was added is independent: covariances stay, so correlations shrink.
  const double height{std::min(previous.height_sigma_m / ground.height_sigma_m, 1.0)};
  const double pitch{std::min(previous.pitch_sigma_rad / ground.pitch_sigma_rad, 1.0)};
  const double roll{std::min(previous.roll_sigma_rad / ground.roll_sigma_rad, 1.0)};
  ground.height_pitch_correlation *= height * pitch;
  ground.height_roll_correlation *= height * roll;
  ground.pitch_roll_correlation *= pitch * roll;
  return ground;
}

Ground estimate_ground(const Rig& rig, const GroundConfig& config, View<const float> road_disparity,
                       const Ground& previous, double dt_s, GroundSpace& space) {
  if (!config.estimate) {
    Ground trusted{previous};
    trusted.estimated = false;
    return trusted;
  }
  const Ground before{predicted(rig, config, previous, dt_s)};
  const RoadPlane expected{road_plane(rig, before)};
  const Matrix3 covariance{carried(numbers_by_ground(rig, before), covariance_of(before))};
  space.samples.clear();
  add_samples(road_disparity, first_row(rig, before), space.samples);
  RoadPlane plane{expected};
  const double radius_px{refine(space.samples, covariance, plane)};
  PlaneMeasurement measurement;
  if (radius_px == 0 || !measure(plane, radius_px, space, measurement)) return before;

  const Matrix3 gain{covariance * inverse(covariance + measurement.covariance)};
  plane = expected;
  move(plane, gain * (measurement.numbers - numbers_of(expected)));
  if (!(plane.per_v > 0)) return before;
  const Ground found{ground_of(rig, plane)};
  if (!is_believable(rig, config, found)) return before;
  const Matrix3 rest{diagonal({1, 1, 1}) + scaled(-1, gain)};
  // Joseph's form keeps it positive
  const Matrix3 after{carried(rest, covariance) + carried(gain, measurement.covariance)};
  return with_covariance(found, carried(inverse(numbers_by_ground(rig, found)), after));
}

}  // namespace stereogrid
