// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Vehicle pose in the world from the poses of the frames. The world frame begins at the first frame and is continuous.
/// At a pose jump (a receiver that finds its satellites again, a corrected map), the pose frame is shifted, not the
/// vehicle. Decision 17.
class EgoMotion {
 public:
  /// `in_world_of_poses`: the world is that of the first pose.
  explicit EgoMotion(const MotionConfig& config, bool in_world_of_poses = false)
      : config_{config}, in_world_of_poses_{in_world_of_poses} {}

  /// Sets the vehicle's pose in the world at the first frame.
  void start_at(const Pose2& world_from_vehicle) {
    world_from_vehicle_ = world_from_vehicle;
    input_from_world_.reset();
  }
  /// Resets the motion. The next frame's place follows from its pose alone, or is the last one. The world frame is
  /// unchanged.
  void restart();

  /// At the last frame.
  [[nodiscard]] const Pose2& world_from_vehicle() const { return world_from_vehicle_; }

  struct Placing {
    Pose2 world_from_vehicle;
    std::optional<FrameStatus> status{};   ///< pose_missing, pose_jump
    std::optional<std::string> warning{};  ///< none: no status, or given with an earlier frame
  };
  /// The next frame's place. `pose`: of the vehicle in any fixed frame, none: unknown; `dt_s`: since the frame before.
  Placing place(const std::optional<Pose2>& pose, double dt_s);

  template <class State>
  void exchange(State& state) {
    state(world_from_vehicle_, world_from_last_pose_, last_pose_, since_pose_s_, before_s_, input_from_world_, rate_,
          pose_rate_, has_warned_);
  }

 private:
  // Motion per second, in the vehicle's axes.
  struct Rate {
    double x_mps{0};
    double y_mps{0};
    double yaw_radps{0};
  };
  [[nodiscard]] std::optional<Rate> rate_of(const Pose2& motion) const;
  static Pose2 motion_of(const std::optional<Rate>& rate, double dt_s);

  Placing place_without_pose(double dt_s);
  Placing move_along(const Pose2& pose, const Pose2& motion);
  [[nodiscard]] bool is_drivable(const Pose2& motion) const;
  [[nodiscard]] bool follows(const Pose2& motion, const std::optional<Rate>& rate) const;

  MotionConfig config_;
  bool in_world_of_poses_;
  Pose2 world_from_vehicle_;
  Pose2 world_from_last_pose_;             // the vehicle at the last frame that had a pose
  std::optional<Pose2> last_pose_;         // last pose; none: no pose yet
  double since_pose_s_{0};                 // the time since then …
  double before_s_{0};                     // … and between that pose and the one before it
  std::optional<Pose2> input_from_world_;  // none: no pose yet
  std::optional<Rate> rate_;               // accepted motion of the vehicle
  std::optional<Rate> pose_rate_;          // motion of the poses, accepted or not, if plausible
  bool has_warned_{false};
};

}  // namespace stereogrid
