// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/odometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "landmarks.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid {
namespace {

constexpr double standing_px{0.1};
constexpr std::size_t points_min{15};
constexpr double new_reference_m{0.25};
constexpr double new_reference_rad{0.02};
constexpr double kept_share_min{0.6};  // share of the landmarks; below: a new reference
// limit of a car plus measurement noise
constexpr double acceleration_max_mps2{12};
constexpr double turn_acceleration_max_radps2{3};
// measured on scenes and KITTI drives
constexpr double points_that_err_together{4};  // neighbouring corners share their errors
constexpr double share_of_way{0.01};           // error of calibration and extrinsics, the same in each step
constexpr double unmeasured_variance{1e6};     // m², rad²: no motion was ever measured
constexpr double slack_m{0.05};
constexpr double slack_rad{0.02};

std::array<double, 12> numbers_of(const cv::Affine3d& motion) {
  std::array<double, 12> numbers{};
  std::copy_n(motion.matrix.val, numbers.size(), numbers.begin());
  return numbers;
}

/// level_from_camera: rotation to the axes of a level camera at the same position.
cv::Affine3d level_from_camera(const Rig& rig) {
  return cv::Affine3d{cv::Vec3d{-rig.camera_pitch_rad, 0, 0}} * cv::Affine3d{cv::Vec3d{0, 0, rig.camera_roll_rad}};
}

using Covariance = cv::Matx33d;  // over x, y, heading, on the ground

/// Covariance of the ground pose, axes of the vehicle now. `of_camera`: covariance_of().
Covariance on_ground(const cv::Matx66d& of_camera, const cv::Affine3d& level) {
  const cv::Matx33d l{level.rotation()};
  const cv::Matx<double, 3, 6> ahead_left_heading{0,        0,        0,        l(2, 0),  l(2, 1),  l(2, 2),  0, 0, 0,
                                                  -l(0, 0), -l(0, 1), -l(0, 2), -l(1, 0), -l(1, 1), -l(1, 2), 0, 0, 0};
  return ahead_left_heading * of_camera * ahead_left_heading.t();
}

/// Covariance of world_from_now from that of world_from_before and that of the motion, axes of the vehicle now.
Covariance after(const Covariance& before, const Pose2& world_from_before, const Covariance& motion,
                 const Pose2& world_from_now) {
  const double c{std::cos(world_from_now.yaw_rad)};
  const double s{std::sin(world_from_now.yaw_rad)};
  const cv::Matx33d lever{
      1, 0, world_from_before.y_m - world_from_now.y_m, 0, 1, world_from_now.x_m - world_from_before.x_m, 0, 0, 1};
  const cv::Matx33d turn{c, -s, 0, s, c, 0, 0, 0, 1};
  return lever * before * lever.t() + turn * motion * turn.t();
}

/// Place of the camera relative to the reference frame.
struct Placed {
  cv::Affine3d reference_from_now;
  Covariance covariance;  // covariance of the ground pose, vehicle axes
};

std::array<double, 9> numbers_of(const Covariance& covariance) {
  std::array<double, 9> numbers{};
  std::copy_n(covariance.val, numbers.size(), numbers.begin());
  return numbers;
}

/// With the errors that all steps of a way have in common.
std::array<double, 9> with_common(Covariance covariance, const Pose2& way) {
  const double variance_m2{share_of_way * share_of_way * (way.x_m * way.x_m + way.y_m * way.y_m)};
  covariance(0, 0) += variance_m2;
  covariance(1, 1) += variance_m2;
  return numbers_of(covariance);
}

double angle_of(const cv::Affine3d& motion) {
  return cv::norm(motion.rvec());
}

/// Rotation and translation per second.
struct Speed {
  cv::Vec3d turn_radps;
  cv::Vec3d move_mps;

  [[nodiscard]] cv::Affine3d over(double dt_s) const { return {turn_radps * dt_s, move_mps * dt_s}; }
};

double spread_of(const std::vector<int>& inliers, const Tracks& tracks, const Rig& rig) {
  constexpr int across{6};
  constexpr int down{3};
  std::set<int> parts;
  for (const int place : inliers) {
    const cv::Point2f& at{tracks.at_px[static_cast<std::size_t>(place)]};
    parts.insert(static_cast<int>(at.x) * across / rig.width_px +
                 static_cast<int>(at.y) * down / rig.height_px * across);
  }
  return static_cast<double>(parts.size()) / (across * down);
}

}  // namespace

struct VisualOdometry::Implementation {
  Implementation(const Rig& a_rig, Image<std::uint8_t> a_mask)
      : rig{a_rig}, mask{std::move(a_mask)}, level{level_from_camera(a_rig)} {
    if (mask.empty() || (mask.width() == rig.width_px && mask.height() == rig.height_px)) return;
    throw InputError{"The mask does not have the size of the rig's images."};
  }

  void check(const StereoFrame& frame) const {
    const auto fits = [&](const auto& image) {
      return image.width() == rig.width_px && image.height() == rig.height_px;
    };
    if (!fits(frame.left) || !(frame.right.empty() ? fits(frame.disparity) : fits(frame.right))) {
      throw InputError{"frame " + frame.name, "the images do not have the calibration's size.",
                       fmt::format("Both must be {} × {}.", rig.width_px, rig.height_px)};
    }
    if (last_stamp_ns && frame.stamp_ns <= *last_stamp_ns) {
      throw InputError{"frame " + frame.name, "its stamp is not after that of the frame before.",
                       "Frames must come in the order of their stamps."};
    }
  }

  void take_as_reference(const StereoFrame& frame, Pyramid pyramid) {
    Landmarks found{find_landmarks(frame, pyramid, rig, mask)};
    // in the dark the old one may serve again when there is light
    if (found.at_px.size() < points_min && landmarks.at_px.size() >= points_min) return;
    landmarks = std::move(found);
    reference = std::move(pyramid);
    covariance_at_reference = covariance_of_last();
    covariance_since_reference = Covariance::zeros();
    world_from_reference = world_from_last;
    reference_from_last = cv::Affine3d::Identity();
    last_at_px = landmarks.at_px;
  }

  [[nodiscard]] Covariance covariance_of_last() const {
    return after(covariance_at_reference, world_from_reference, covariance_since_reference, world_from_last);
  }

  [[nodiscard]] bool is_plausible(const cv::Affine3d& before_from_now, double dt_s) const {
    if (!speed) return true;
    const cv::Affine3d expected{speed->over(dt_s)};
    const double gain{(dt_s + unmeasured_s) * dt_s};
    return cv::norm(before_from_now.translation() - expected.translation()) <= slack_m + acceleration_max_mps2 * gain &&
           angle_of(expected.inv() * before_from_now) <= slack_rad + turn_acceleration_max_radps2 * gain;
  }

  // Against the last frame that moved, so that creeping adds up and is seen.
  [[nodiscard]] bool stands(const Tracks& tracks) const {
    if (unmeasured_s > 0 || tracks.at_px.size() < points_min) return false;
    std::vector<double> flow_px;
    for (std::size_t i{0}; i < tracks.at_px.size(); ++i) {
      flow_px.push_back(cv::norm(tracks.at_px[i] - last_at_px[static_cast<std::size_t>(tracks.landmark[i])]));
    }
    const auto middle{flow_px.begin() + static_cast<std::ptrdiff_t>(flow_px.size() / 2)};
    std::nth_element(flow_px.begin(), middle, flow_px.end());
    return *middle < standing_px;
  }

  // Without a measured motion: the last one continues, and may have changed as much as is plausible.
  [[nodiscard]] Covariance continued(double dt_s) const {
    if (!speed) return Covariance::eye() * unmeasured_variance;
    const double gain{(dt_s + unmeasured_s) * dt_s};
    const double way_m{acceleration_max_mps2 * gain};
    const double turn_rad{turn_acceleration_max_radps2 * gain};
    return covariance_since_reference + Covariance::diag({way_m * way_m, way_m * way_m, turn_rad * turn_rad});
  }

  // The camera's place relative to the reference; fills in what the step says of its quality.
  Placed measure(const Tracks& tracks, double dt_s, OdometryStep& step) {
    const auto measured = [&](const cv::Affine3d& reference_from_now, const std::vector<int>& inliers) {
      step.measured = true;
      step.inliers = static_cast<int>(inliers.size());
      step.spread = spread_of(inliers, tracks, rig);
      const cv::Affine3d now_from_reference{reference_from_now.inv()};
      return Placed{reference_from_now,
                    on_ground(covariance_of(now_from_reference, inliers, landmarks, tracks, rig), level) *
                        points_that_err_together};
    };
    const cv::Affine3d expected{reference_from_last * (speed ? speed->over(dt_s) : cv::Affine3d::Identity())};
    step.tracked = static_cast<int>(tracks.at_px.size());
    if (stands(tracks)) {
      step.standing = true;
      std::vector<int> all(tracks.at_px.size());
      std::iota(all.begin(), all.end(), 0);
      return measured(reference_from_last, all);
    }
    const auto fit{fit_motion(landmarks, tracks, speed ? std::optional{expected.inv()} : std::nullopt, rig,
                              [&](const cv::Affine3d& now_from_reference) {
                                return is_plausible((now_from_reference * reference_from_last).inv(), dt_s);
                              })};
    if (!fit) {
      step.warning = "odometry: too few points agree on a motion, the last motion continues";
      return {expected, continued(dt_s)};
    }
    return measured(fit->now_from_reference.inv(), fit->inliers);
  }

  OdometryStep advance(const StereoFrame& frame, double dt_s) {
    OdometryStep step;
    Pyramid pyramid{pyramid_of(frame.left)};
    const cv::Affine3d expected{reference_from_last * (speed ? speed->over(dt_s) : cv::Affine3d::Identity())};
    const Tracks tracks{follow(landmarks, reference, pyramid, expected.inv(), rig)};
    const auto [reference_from_now, covariance]{measure(tracks, dt_s, step)};
    const cv::Affine3d motion{reference_from_last.inv() * reference_from_now};
    step.camera_motion = numbers_of(motion);
    unmeasured_s = step.measured ? 0 : unmeasured_s + dt_s;
    if (step.measured) speed = Speed{motion.rvec() * (1 / dt_s), motion.translation() * (1 / dt_s)};
    step.covariances.motion =
        with_common(covariance_since_reference + covariance, ground_pose(numbers_of(level * motion * level.inv())));
    if (step.standing) return step;
    covariance_since_reference = covariance;
    world_from_last = world_from_reference * ground_pose(numbers_of(level * reference_from_now * level.inv()));
    reference_from_last = reference_from_now;
    for (std::size_t i{0}; i < tracks.at_px.size(); ++i) {
      last_at_px[static_cast<std::size_t>(tracks.landmark[i])] = tracks.at_px[i];
    }
    const bool far{cv::norm(reference_from_now.translation()) > new_reference_m ||
                   angle_of(reference_from_now) > new_reference_rad};
    if (far || step.inliers < kept_share_min * static_cast<double>(landmarks.at_px.size())) {
      take_as_reference(frame, std::move(pyramid));
    }
    return step;
  }

  Rig rig;
  Image<std::uint8_t> mask;
  cv::Affine3d level;
  Pyramid reference;
  Landmarks landmarks;
  Pose2 world_from_reference;
  Pose2 world_from_last;
  cv::Affine3d reference_from_last;
  std::vector<cv::Point2f> last_at_px;  // positions of the landmarks in the last frame that moved
  Covariance covariance_at_reference{Covariance::zeros()};
  Covariance covariance_since_reference{Covariance::zeros()};
  std::optional<Speed> speed;  // none: nothing measured yet
  double unmeasured_s{0};
  std::optional<std::int64_t> last_stamp_ns;
};

namespace {

Image<std::uint8_t> image_of(const Pyramid& pyramid) {
  Image<std::uint8_t> image;
  if (!pyramid.empty()) assign(image, view_of(pyramid.front()));
  return image;
}

cv::Affine3d motion_of(const std::array<double, 12>& numbers) {
  cv::Affine3d motion;
  std::copy(numbers.begin(), numbers.end(), motion.matrix.val);
  return motion;
}

}  // namespace

OdometryState VisualOdometry::save_state() const {
  const Implementation& self{*implementation_};
  OdometryState state{.reference = image_of(self.reference),
                      .landmarks = {},
                      .world_from_reference = self.world_from_reference,
                      .world_from_last = self.world_from_last,
                      .reference_from_last = numbers_of(self.reference_from_last),
                      .speed = {},
                      .unmeasured_s = self.unmeasured_s,
                      .covariance_at_reference = numbers_of(self.covariance_at_reference),
                      .covariance_since_reference = numbers_of(self.covariance_since_reference),
                      .last_stamp_ns = self.last_stamp_ns};
  for (std::size_t i{0}; i < self.landmarks.at_px.size(); ++i) {
    const cv::Point2f& at{self.landmarks.at_px[i]};
    const cv::Point3f& in_camera{self.landmarks.in_camera[i]};
    const cv::Point2f& last{self.last_at_px[i]};
    state.landmarks.push_back({{at.x, at.y}, {in_camera.x, in_camera.y, in_camera.z}, {last.x, last.y}});
  }
  if (self.speed) {
    const auto& [turn, move]{*self.speed};
    state.speed = {turn[0], turn[1], turn[2], move[0], move[1], move[2]};
  }
  return state;
}

void VisualOdometry::load_state(const OdometryState& state) {
  Implementation& self{*implementation_};
  const bool fits{state.reference.width() == self.rig.width_px && state.reference.height() == self.rig.height_px};
  if (!state.reference.empty() && !fits) {
    throw InputError{"saved odometry", "has a reference image that does not have the calibration's size.",
                     "Begin without it."};
  }
  self.reference = state.reference.empty() ? Pyramid{} : pyramid_of(state.reference);
  self.landmarks = {};
  self.last_at_px.clear();
  for (const auto& [at, in_camera, last] : state.landmarks) {
    self.landmarks.at_px.emplace_back(at[0], at[1]);
    self.landmarks.in_camera.emplace_back(in_camera[0], in_camera[1], in_camera[2]);
    self.last_at_px.emplace_back(last[0], last[1]);
  }
  self.world_from_reference = state.world_from_reference;
  self.world_from_last = state.world_from_last;
  self.reference_from_last = motion_of(state.reference_from_last);
  self.speed.reset();
  if (const auto& s{state.speed}) self.speed = Speed{{(*s)[0], (*s)[1], (*s)[2]}, {(*s)[3], (*s)[4], (*s)[5]}};
  self.unmeasured_s = state.unmeasured_s;
  self.covariance_at_reference = Covariance{state.covariance_at_reference.data()};
  self.covariance_since_reference = Covariance{state.covariance_since_reference.data()};
  self.last_stamp_ns = state.last_stamp_ns;
}

VisualOdometry::VisualOdometry(const Rig& rig, Image<std::uint8_t> mask)
    : implementation_{std::make_unique<Implementation>(rig, std::move(mask))} {}
VisualOdometry::VisualOdometry(VisualOdometry&&) noexcept = default;
VisualOdometry& VisualOdometry::operator=(VisualOdometry&&) noexcept = default;
VisualOdometry::~VisualOdometry() = default;

OdometryStep VisualOdometry::update(const StereoFrame& frame) {
  Implementation& self{*implementation_};
  self.check(frame);
  OdometryStep step;
  if (self.last_stamp_ns) {
    step = self.advance(frame, static_cast<double>(frame.stamp_ns - *self.last_stamp_ns) * 1e-9);
  } else {
    self.take_as_reference(frame, pyramid_of(frame.left));
  }
  self.last_stamp_ns = frame.stamp_ns;
  step.world_from_vehicle = self.world_from_last;
  step.covariances.pose = with_common(self.covariance_of_last(), self.world_from_last);
  return step;
}

}  // namespace stereogrid
