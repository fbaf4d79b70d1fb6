// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/frame_tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>

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
constexpr double short_path_min_m{0.5};  // for fewer steps
constexpr double kept_share{0.8};        // steps that fit best: poses may jump
// Differences that the poses of recorded drives do not have.
constexpr double yaw_max_rad{10 * per_degree};
constexpr double scale_max{1.25};
constexpr double lever_max_m{0.3};
constexpr double residual_max{0.3};  // share of the travel
constexpr double sigmas{3};
// The same of fewer steps than steps_min.
constexpr double short_yaw_max_rad{45 * per_degree};
constexpr double short_scale_max{2};
constexpr double unseen_scale{5};  // poses and images have no path in common beyond it

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

double travelled_m(std::span<const MotionPair> steps, Pose2 MotionPair::*motion = &MotionPair::seen) {
  double sum{0};
  for (const MotionPair& step : steps) sum += std::abs(place(step.*motion));
  return sum;
}

/// Median length of the steps, m.
double usual_step_m(std::span<const MotionPair> steps, Pose2 MotionPair::*motion) {
  std::vector<double> lengths;
  for (const MotionPair& step : steps) lengths.push_back(std::abs(place(step.*motion)));
  const auto middle{lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2)};
  std::ranges::nth_element(lengths, middle);
  return *middle;
}

constexpr const char* remedy_of_scale{"Check their unit (m), baseline_m and the focal length."};

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
  const bool are_few{steps.size() < steps_min};
  const double path_m{std::max(travelled_m(steps), travelled_m(steps, &MotionPair::external))};
  if (steps.empty() || path_m < (are_few ? short_path_min_m : path_min_m)) return std::nullopt;
  constexpr const char* const beginning{"the poses contradict the motion in the images, in {} steps over {:.1f} m: "};
  const double seen_m{usual_step_m(steps, &MotionPair::seen)};
  const double external_m{usual_step_m(steps, &MotionPair::external)};
  if (external_m >= compared_m && external_m > unseen_scale * seen_m) {
    return fmt::format(beginning, steps.size(), travelled_m(steps)) +
           fmt::format("they move {:.1f} m. {}", travelled_m(steps, &MotionPair::external), remedy_of_scale);
  }
  const HandEye first{fitted(steps)};
  const auto error = [&](const MotionPair& step) { return std::norm(first.residual(step)); };
  std::ranges::sort(steps, [&](const MotionPair& a, const MotionPair& b) { return error(a) < error(b); });
  steps.resize(static_cast<std::size_t>(std::ceil(kept_share * static_cast<double>(steps.size()))));
  const HandEye fit{fitted(steps)};
  double travel_m2{0};
  double turn_rad2{0};
  double turn_error_rad2{0};
  double seen_rad{0};
  double drift_rad{0};
  for (const MotionPair& step : steps) {
    const double turn_error_rad{std::remainder(step.external.yaw_rad - step.seen.yaw_rad, 360 * per_degree)};
    seen_rad += step.seen.yaw_rad;
    drift_rad += turn_error_rad;
    travel_m2 += std::norm(place(step.seen));
    turn_rad2 += std::norm(step.seen.yaw_rad) + compared_rad * compared_rad;
    turn_error_rad2 += std::norm(turn_error_rad);
  }
  const double scale{std::abs(fit.turn)};
  const double yaw_rad{std::arg(fit.turn)};
  const double most_scale{are_few ? short_scale_max : scale_max};
  const bool is_other_motion{!are_few && (residual_m2(fit, steps) > residual_max * residual_max * travel_m2 ||
                                          turn_error_rad2 > residual_max * residual_max * turn_rad2 ||
                                          std::abs(drift_rad) > residual_max * std::abs(seen_rad) + compared_rad)};
  const bool is_scaled{scale > most_scale || scale < 1 / most_scale};
  const bool is_turned{std::abs(yaw_rad) > (are_few ? short_yaw_max_rad : yaw_max_rad)};
  const bool is_away{!are_few && std::abs(fit.lever) > lever_max_m};
  if (!is_other_motion && !is_scaled && !is_turned && !is_away) return std::nullopt;
  const std::string text{fmt::format(beginning, steps.size(), travelled_m(steps))};
  constexpr const char* const remedy{
      " Poses are of the point on the road below the left camera, x forward (docs/input.md, Poses). Transform them, or "
      "use --poses odometry."};
  if (is_other_motion) return text + "they follow another path. Are they of this drive, in m and rad?" + remedy;
  if (is_scaled) return text + fmt::format("they move {:.2f} times as far. {}", scale, remedy_of_scale);
  const std::string where{fit.lever_sigma > 0 ? fmt::format("at x {:.2f} m, y {:.2f} m (± {:.2f} m) of their frame",
                                                            fit.lever.real(), fit.lever.imag(), fit.lever_sigma)
                                              : "at a place that a straight drive does not show"};
  return text + fmt::format("they fit a camera that is turned by {:.0f}° (yaw), {}.", yaw_rad / per_degree, where) +
         remedy;
}

namespace {

/// Pose of a frame by the images and by the poses that came with them.
struct PlacedFrame {
  Pose2 seen;
  Pose2 external;
};

/// Runs of frames in the middle of the input whose poses are both known.
std::vector<std::vector<PlacedFrame>> placed_frames(const Input& input) {
  VisualOdometry odometry{input.source->rig(), input.mask};
  const std::size_t size{input.source->size()};
  const std::size_t first{size > frames_compared ? (size - frames_compared) / 2 : 0};
  std::vector<std::vector<PlacedFrame>> runs(1);
  for (std::size_t i{first}; i < std::min(size, first + frames_compared); ++i) {
    try {
      const StereoFrame frame{input.source->load(i)};
      const OdometryStep step{odometry.update(frame)};
      if (!step.warning && frame.world_from_vehicle) {
        runs.back().push_back({step.world_from_vehicle, *frame.world_from_vehicle});
        continue;
      }
    } catch (const InputError&) {  // reported where the frames are processed
    }
    runs.emplace_back();
  }
  return runs;
}

/// Steps between frames far enough from each other. `change`: of the poses that came with the images.
std::vector<MotionPair> steps_of(const std::vector<std::vector<PlacedFrame>>& runs,
                                 const std::function<Pose2(const Pose2&)>& change) {
  const auto is_long = [](const Pose2& moved) {
    return std::abs(place(moved)) >= compared_m || std::abs(moved.yaw_rad) >= compared_rad;
  };
  std::vector<MotionPair> steps;
  for (const std::vector<PlacedFrame>& run : runs) {
    if (run.empty()) continue;
    PlacedFrame from{run.front()};
    for (const PlacedFrame& now : run) {
      const MotionPair moved{inverse(from.seen) * now.seen, inverse(change(from.external)) * change(now.external)};
      if (!is_long(moved.seen) && !is_long(moved.external)) continue;
      steps.push_back(moved);
      from = now;
    }
  }
  return steps;
}

}  // namespace

std::optional<std::string> contradiction_of_poses(const Input& input) {
  if (input.poses != PoseSource::input || input.recording == nullptr || input.source->size() < 2) return std::nullopt;
  const auto runs{placed_frames(input)};
  const auto with = [&](const std::function<Pose2(const Pose2&)>& change) {
    return contradiction_of(steps_of(runs, change));
  };
  std::optional<std::string> text{with([](const Pose2& pose) { return pose; })};
  if (!text) return std::nullopt;
  if (!with([](const Pose2& pose) { return inverse(pose); })) {
    return "the poses seem to be inverted: they fit the motion in the images as camera_from_world, but "
           "world_from_camera is needed. Invert them, or use --poses odometry.";
  }
  // a heading in radians may also be beyond a turn, but then it fits the images
  const auto is_beyond_a_turn = [](const PlacedFrame& one) {
    return std::abs(one.external.yaw_rad) > 360 * per_degree;
  };
  const bool may_be_degrees{
      std::ranges::any_of(runs, [&](const auto& run) { return std::ranges::any_of(run, is_beyond_a_turn); })};
  if (may_be_degrees && !with([](const Pose2& pose) { return Pose2{pose.x_m, pose.y_m, pose.yaw_rad * per_degree}; })) {
    return "the headings of the poses seem to be in degrees: as such they fit the motion in the images. Give yaw_rad "
           "in radians (docs/input.md, Poses).";
  }
  if (!with([](const Pose2& pose) { return Pose2{pose.x_m, -pose.y_m, -pose.yaw_rad}; })) {
    return "the images turn to the other side than the poses: the images are mirrored, or y and the heading of the "
           "poses have the other sign (docs/input.md, Poses).";
  }
  return text;
}

}  // namespace stereogrid::app
