// SPDX-License-Identifier: Apache-2.0
#include "motion/ego_motion.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace stereogrid {
namespace {

constexpr double degree{3.14159265358979323846 / 180};

// Limits of a road vehicle. Poses beyond them count as a jump of their source.
constexpr double speed_max_mps{70};
constexpr double acceleration_max_mps2{12};  // along and across
constexpr double yaw_rate_max_degps{120};
constexpr double yaw_acceleration_max_degps2{180};
// Smaller steps off the expected pose are noise.
constexpr double jump_min_m{0.3};
constexpr double jump_min_deg{1};

std::string text_of(const Pose2& jump) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "pose jump of %.1f m and %.1f° from the predicted pose: the pose frame is shifted",
                std::hypot(jump.x_m, jump.y_m), std::abs(jump.yaw_rad) / degree);
  return text.data();
}

}  // namespace

// None where it is no vehicle's: within next to no time the noise of a pose is a fantastic speed.
std::optional<EgoMotion::Rate> EgoMotion::rate_of(const Pose2& motion) const {
  const Rate rate{motion.x_m / since_pose_s_, motion.y_m / since_pose_s_, motion.yaw_rad / since_pose_s_};
  const bool is_possible{std::hypot(rate.x_mps, rate.y_mps) <= speed_max_mps &&
                         std::abs(rate.yaw_radps) <= degree * yaw_rate_max_degps};
  return is_possible ? std::optional{rate} : std::nullopt;
}

Pose2 EgoMotion::motion_of(const std::optional<Rate>& rate, double dt_s) {
  if (!rate) return {};
  return {rate->x_mps * dt_s, rate->y_mps * dt_s, rate->yaw_radps * dt_s};
}

bool EgoMotion::is_drivable(const Pose2& motion) const {
  return std::hypot(motion.x_m, motion.y_m) <= jump_min_m + speed_max_mps * since_pose_s_ &&
         std::abs(motion.yaw_rad) <= degree * (jump_min_deg + yaw_rate_max_degps * since_pose_s_);
}

// A mean rate belongs to the middle of its interval: from middle to middle it may have changed by the acceleration.
bool EgoMotion::follows(const Pose2& motion, const std::optional<Rate>& rate) const {
  if (!rate) return false;
  const Pose2 expected{motion_of(rate, since_pose_s_)};
  const double gain_s2{since_pose_s_ * (since_pose_s_ + before_s_) / 2};
  const double off_m{std::hypot(motion.x_m - expected.x_m, motion.y_m - expected.y_m)};
  const double off_rad{std::abs(std::remainder(motion.yaw_rad - expected.yaw_rad, 360 * degree))};
  return off_m <= jump_min_m + acceleration_max_mps2 * gain_s2 &&
         off_rad <= degree * (jump_min_deg + yaw_acceleration_max_degps2 * gain_s2);
}

EgoMotion::Placing EgoMotion::place_without_pose(double dt_s) {
  world_from_vehicle_ = world_from_vehicle_ * motion_of(rate_, dt_s);
  Placing placing{world_from_vehicle_};
  // without any pose so far this may be intended
  if (!has_warned_ || input_from_world_) placing.status = FrameStatus::pose_missing;
  if (!std::exchange(has_warned_, true)) {
    placing.warning = rate_ ? "no pose: the last motion continues" : "no pose: the vehicle is assumed to be static";
  }
  return placing;
}

EgoMotion::Placing EgoMotion::move_along(const Pose2& pose, const Pose2& motion) {
  const Pose2 expected{motion_of(rate_, since_pose_s_)};
  world_from_vehicle_ = world_from_last_pose_ * expected;
  input_from_world_ = pose * inverse(world_from_vehicle_);
  return {world_from_vehicle_, FrameStatus::pose_jump, text_of(inverse(expected) * motion)};
}

void EgoMotion::restart() {
  last_pose_.reset();
  rate_.reset();
  pose_rate_.reset();
  since_pose_s_ = before_s_ = 0;
  has_warned_ = has_warned_ && !input_from_world_;
}

EgoMotion::Placing EgoMotion::place(const std::optional<Pose2>& pose, double dt_s) {
  since_pose_s_ += dt_s;
  if (!pose) return place_without_pose(dt_s);
  if (!input_from_world_) {
    input_from_world_ = in_world_of_poses_ ? Pose2{} : *pose * inverse(world_from_vehicle_);
  }
  Placing placing{inverse(*input_from_world_) * *pose};
  if (last_pose_) {
    const Pose2 motion{inverse(*last_pose_) * *pose};
    const bool drivable{is_drivable(motion)};
    const bool is_plausible{!config_.detect_jumps ||
                            (drivable && (!rate_ || follows(motion, rate_) || follows(motion, pose_rate_)))};
    const std::optional<Rate> rate{rate_of(motion)};
    if (!is_plausible) placing = move_along(*pose, motion);
    if (is_plausible && rate) rate_ = rate;
    pose_rate_ = drivable ? rate : std::nullopt;
    before_s_ = since_pose_s_;
  }
  world_from_vehicle_ = world_from_last_pose_ = placing.world_from_vehicle;
  last_pose_ = pose;
  since_pose_s_ = 0;
  has_warned_ = false;
  return placing;
}

}  // namespace stereogrid
