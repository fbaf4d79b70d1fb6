// SPDX-License-Identifier: Apache-2.0
//
// The first and the next state of the ground.
#include <algorithm>
#include <cmath>
#include <utility>

#include "ground/ground_estimator.hpp"

namespace stereogrid {
namespace {

constexpr int candidate_frames_min{3};
// The extrinsics learns from frames with that share of the nearest half on the plane.
constexpr double learning_share_min{0.6};
// Largest errors of a given extrinsics.
constexpr double given_height_max{0.06};  // share of the height
constexpr double given_pitch_max{radians(1)};
constexpr double given_roll_max{radians(1.5)};
// Distance over which a better plane must hold, in heights of the camera.
constexpr double travel_of_height{4};

bool agree(const Ground& a, const Ground& b) {
  return std::abs(a.height_m - b.height_m) <= 0.1 * b.height_m + 0.02 &&
         std::abs(a.pitch_rad - b.pitch_rad) <= radians(1.5) && std::abs(a.roll_rad - b.roll_rad) <= radians(2);
}

Ground mean_with(const Ground& mean, int count, const Ground& next) {
  const Vector3 step{difference(next, mean)};
  return {mean.height_m + step[0] / (count + 1), mean.pitch_rad + step[1] / (count + 1),
          mean.roll_rad + step[2] / (count + 1)};
}

// `assumed`: extrinsics that this frame alone, or three that agree, determine.
std::optional<Ground> agreed(const GroundFit& fit, GroundState& next) {
  if (fit.is_sound) return fit.plane;
  if (!fit.is_candidate) return std::nullopt;
  const bool agrees{next.candidate && agree(fit.plane, *next.candidate)};
  next.candidate = agrees ? mean_with(*next.candidate, next.candidate_frames, fit.plane) : fit.plane;
  next.candidate_frames = agrees ? next.candidate_frames + 1 : 1;
  return next.candidate_frames >= candidate_frames_min ? next.candidate : std::nullopt;
}

// The extrinsics learn from frames where nothing disagrees.
void learn(const GroundFit& fit, double dt_s, GroundState& next) {
  if (fit.disagreeing || fit.support.near_share() < learning_share_min || !(dt_s > 0)) return;
  Ground& extrinsics{next.extrinsics};
  const Matrix3 of_a_frame{scaled(std::max(correlated_s / dt_s, 1.0), suspension(extrinsics))};
  extrinsics = fused(extrinsics, covariance_of(extrinsics), fit.plane, covariance_of(fit.plane) + of_a_frame);
  if (!next.given) return;
  const Ground& given{*next.given};
  const auto bounded = [](double value, double around, double most) {
    return std::clamp(value, around - most, around + most);
  };
  extrinsics.height_m = bounded(extrinsics.height_m, given.height_m, given_height_max * given.height_m);
  extrinsics.pitch_rad = bounded(extrinsics.pitch_rad, given.pitch_rad, given_pitch_max);
  extrinsics.roll_rad = bounded(extrinsics.roll_rad, given.roll_rad, given_roll_max);
}

double distance(Point2 a, Point2 b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

// A slope that does not end is a camera that was moved.
bool is_on_slope(const GroundFit& fit, Point2 place, GroundState& next) {
  constexpr double slope_heights_max{10};
  if (!std::exchange(next.on_slope, fit.slope.has_value())) next.slope_from = place;
  return next.on_slope && distance(place, next.slope_from) <= slope_heights_max * next.extrinsics.height_m;
}

// `found`: extrinsics that replace others that were never confirmed, or that have explained all nearest ground while
// the vehicle travelled.
std::optional<Ground> replaced(const GroundFit& fit, Point2 place, GroundState& next) {
  if (!fit.replacement) return std::nullopt;
  if (fit.replaces_at_once) return fit.replacement;
  if (!next.better || !agree(*fit.replacement, *next.better)) {
    next.better = fit.replacement;
    next.better_from = place;
    return std::nullopt;
  }
  const bool has_travelled{distance(place, next.better_from) >= travel_of_height * fit.replacement->height_m};
  return has_travelled ? fit.replacement : std::nullopt;
}

}  // namespace

GroundState first_ground(const Ground& extrinsics, GroundMode mode) {
  const Vector3 sigmas{{0.03 * extrinsics.height_m, radians(0.5), radians(0.7)}};
  GroundState state;
  state.mode = mode;
  state.extrinsics =
      with_covariance(extrinsics, diagonal({{sigmas[0] * sigmas[0], sigmas[1] * sigmas[1], sigmas[2] * sigmas[2]}}));
  state.extrinsics.estimated = false;
  state.plane = state.extrinsics;
  if (mode == GroundMode::given) state.given = state.extrinsics;
  return state;
}

SettledGround GroundEstimator::settle(const GroundState& state, const GroundFit& fit, bool is_usable, double dt_s,
                                      Point2 place) const {
  SettledGround settled{state, {}};
  GroundState& next{settled.state};
  if (!config_.estimate) return settled;
  next.unmeasured_s += dt_s;
  if (!is_usable) {
    next.plane.estimated = false;
    return settled;
  }
  if (state.mode == GroundMode::assumed) {
    settled.new_extrinsics = agreed(fit, next);
  } else {
    next.plane = fit.plane;
    if (is_on_slope(fit, place, next) || fit.plane.estimated) next.unmeasured_s = 0;
    if (fit.plane.estimated && !fit.replacement) {
      next.agreeing = std::min(next.agreeing + 1, agreeing_min);
      next.better = std::nullopt;
      learn(fit, dt_s, next);
    }
    settled.new_extrinsics = replaced(fit, place, next);
  }
  if (settled.new_extrinsics) next = first_ground(*settled.new_extrinsics, GroundMode::found);
  return settled;
}

}  // namespace stereogrid
