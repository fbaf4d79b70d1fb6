// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/frame_tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "stereogrid/error.hpp"
#include "stereogrid/odometry.hpp"

namespace stereogrid::app {
namespace {

using Complex = std::complex<double>;

constexpr double per_degree{0.017453292519943295};
constexpr std::size_t frames_compared{50};
// A step between two compared frames: longer than the errors of visual odometry.
constexpr double compared_m{0.25};
constexpr double compared_rad{0.05};
constexpr std::size_t steps_min{5};
constexpr double path_min_m{1};
constexpr double kept_share{0.8};  // steps that fit best: poses may jump
// Differences that the poses of recorded drives do not have.
constexpr double yaw_max_rad{10 * per_degree};
constexpr double scale_max{1.25};
constexpr double lever_max_m{0.3};
constexpr double residual_max{0.3};  // share of the travel
constexpr double sigmas{3};

Complex place(const Pose2& pose) {
  return {pose.x_m, pose.y_m};
}

/// Place of the camera's vehicle frame in the frame of the poses. A step p of the poses and a step v of the camera that
/// turns by a: p = turn·v + (1 − exp(i·a))·lever; the hand-eye equation on the ground.
struct HandEye {
  Complex turn{1};       ///< scale and yaw
  Complex lever{};       ///< m
  double lever_sigma{};  ///< m; 0: unobserved, and taken to be 0

  [[nodiscard]] Complex residual(const MotionPair& step) const {
    return place(step.external) - turn * place(step.seen) - lever_factor(step) * lever;
  }
  static Complex lever_factor(const MotionPair& step) { return 1.0 - std::polar(1.0, step.seen.yaw_rad); }
};

double travelled_m(std::span<const MotionPair> steps) {
  double sum{0};
  for (const MotionPair& step : steps) sum += std::abs(place(step.seen));
  return sum;
}

double residual_m2(const HandEye& fit, std::span<const MotionPair> steps) {
  double sum{0};
  for (const MotionPair& step : steps) sum += std::norm(fit.residual(step));
  return sum;
}

// Least squares. Straight drives do not determine the lever.
HandEye fitted(std::span<const MotionPair> steps) {
  double aa{0};
  double bb{0};
  Complex ab{0};
  Complex ap{0};
  Complex bp{0};
  for (const MotionPair& step : steps) {
    const Complex a{place(step.seen)};
    const Complex b{HandEye::lever_factor(step)};
    aa += std::norm(a);
    bb += std::norm(b);
    ab += std::conj(a) * b;
    ap += std::conj(a) * place(step.external);
    bp += std::conj(b) * place(step.external);
  }
  const double determinant{aa * bb - std::norm(ab)};
  HandEye fit{ap / aa, 0, 0};
  if (!(determinant > 1e-9 * aa * aa)) return fit;
  HandEye both{(ap * bb - ab * bp) / determinant, (aa * bp - std::conj(ab) * ap) / determinant, 0};
  const double variance{residual_m2(both, steps) / static_cast<double>(steps.size())};
  both.lever_sigma = std::sqrt(variance * aa / determinant);
  return both.lever_sigma * sigmas < lever_max_m ? both : fit;
}

}  // namespace

std::optional<std::string> contradiction_of(std::span<const MotionPair> pairs) {
  std::vector<MotionPair> steps{pairs.begin(), pairs.end()};
  if (steps.size() < steps_min || travelled_m(steps) < path_min_m) return std::nullopt;
  const HandEye first{fitted(steps)};
  const auto error = [&](const MotionPair& step) { return std::norm(first.residual(step)); };
  std::ranges::sort(steps, [&](const MotionPair& a, const MotionPair& b) { return error(a) < error(b); });
  steps.resize(static_cast<std::size_t>(std::ceil(kept_share * static_cast<double>(steps.size()))));
  const HandEye fit{fitted(steps)};
  double travel_m2{0};
  double turn_rad2{0};
  double turn_error_rad2{0};
  for (const MotionPair& step : steps) {
    travel_m2 += std::norm(place(step.seen));
    turn_rad2 += std::norm(step.seen.yaw_rad) + compared_rad * compared_rad;
    turn_error_rad2 += std::norm(std::remainder(step.external.yaw_rad - step.seen.yaw_rad, 360 * per_degree));
  }
  const double scale{std::abs(fit.turn)};
  const double yaw_rad{std::arg(fit.turn)};
  const bool is_other_motion{residual_m2(fit, steps) > residual_max * residual_max * travel_m2 ||
                             turn_error_rad2 > residual_max * residual_max * turn_rad2};
  const bool is_scaled{scale > scale_max || scale < 1 / scale_max};
  const bool is_turned{std::abs(yaw_rad) > yaw_max_rad};
  const bool is_away{std::abs(fit.lever) > lever_max_m};
  if (!is_other_motion && !is_scaled && !is_turned && !is_away) return std::nullopt;
  const std::string text{fmt::format(
      "the poses contradict the motion in the images, in {} steps over {:.1f} m: ", steps.size(), travelled_m(steps))};
  constexpr const char* const remedy{
      " Poses are of the point on the road below the left camera, x forward (docs/input.md, Poses). Transform them, or "
      "use --poses odometry."};
  if (is_other_motion) return text + "they follow another path. Are they of this drive, in m and rad?" + remedy;
  if (is_scaled)
    return text + fmt::format("they move {:.2f} times as far. Are they in metres, or is baseline_m wrong?", scale);
  const std::string where{fit.lever_sigma > 0 ? fmt::format("at x {:.2f} m, y {:.2f} m (± {:.2f} m) of their frame",
                                                            fit.lever.real(), fit.lever.imag(), fit.lever_sigma)
                                              : "at a place that a straight drive does not show"};
  return text + fmt::format("they fit a camera that is turned by {:.0f}° (yaw), {}.", yaw_rad / per_degree, where) +
         remedy;
}

std::optional<std::string> contradiction_of_poses(const Input& input) {
  if (input.poses != PoseSource::input || input.recording == nullptr || input.source->size() < 2) return std::nullopt;
  VisualOdometry odometry{input.source->rig(), input.mask};
  const std::size_t size{input.source->size()};
  const std::size_t first{size > frames_compared ? (size - frames_compared) / 2 : 0};
  std::vector<MotionPair> steps;
  MotionPair from;  // places at the last compared frame
  bool has_place{false};
  for (std::size_t i{first}; i < std::min(size, first + frames_compared); ++i) {
    try {
      const StereoFrame frame{input.source->load(i)};
      const OdometryStep step{odometry.update(frame)};
      const bool is_placed{!step.warning && frame.world_from_vehicle};
      const MotionPair now{step.world_from_vehicle, frame.world_from_vehicle.value_or(Pose2{})};
      const MotionPair moved{inverse(from.seen) * now.seen, inverse(from.external) * now.external};
      const bool is_long{std::abs(place(moved.seen)) >= compared_m || std::abs(moved.seen.yaw_rad) >= compared_rad};
      if (is_placed && has_place && is_long) steps.push_back(moved);
      if (!is_placed || !has_place || is_long) from = now;
      has_place = is_placed;
    } catch (const InputError&) {  // reported where the frames are processed
      has_place = false;
    }
  }
  return contradiction_of(steps);
}

}  // namespace stereogrid::app
