// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "backend/cpu.hpp"
#include "images/levelling.hpp"
#include "motion/ego_motion.hpp"
#include "pipeline/stages.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// The time from frame to frame, from their stamps, and what to make of a clock that leaps. Decision 19.
class FrameClock {
 public:
  explicit FrameClock(double gap_max_s) : gap_max_s_{gap_max_s} {}

  struct Tick {
    double dt_s{0};                     ///< 0: this frame is a first one
    std::optional<FrameStatus> leap{};  ///< clock_gap or clock_stepped_back: reset the state
    std::string warning{};              ///< message for the leap
  };
  /// True for the stamp of the frame before.
  [[nodiscard]] bool stands_still(std::int64_t stamp_ns) const { return last_ns_ && *last_ns_ == stamp_ns; }
  /// Advances to the next frame.
  Tick tick(std::int64_t stamp_ns);
  /// The next frame is a first one, whatever its stamp.
  void reset() { last_ns_.reset(); }

  template <class State>
  void exchange(State& state) {
    state(last_ns_);
  }

 private:
  double gap_max_s_;
  std::optional<std::int64_t> last_ns_;
};

/// Converts stereo frames to the frame pipeline's input: time step, pose in the world, level images.
class FrameInput {
 public:
  FrameInput(const MotionConfig& config, const Rig& rig, const PipelineOptions& options);

  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] const Rig& level_rig() const { return levelling_.level_rig(); }
  /// Pitch that levelling removes.
  [[nodiscard]] double turned_rad() const { return rig_.camera_pitch_rad - level_rig().camera_pitch_rad; }
  /// Replaces the rig; time and world continue.
  void set_rig(const Rig& rig);

  /// Throws InputError: the frame does not fit the rig, or has the stamp of the frame before.
  void check(const StereoFrame& frame, const FrameImages& images) const;
  /// The views are `images` or of this object's images, until the next call. Sets status and warnings of clock and
  /// poses in `result`.
  LevelFrame convert(const StereoFrame& frame, const FrameImages& images, Cpu& cpu, FrameResult& result);
  /// Time and world between two frames.
  struct Moment {
    FrameClock clock;
    EgoMotion ego_motion;
  };
  [[nodiscard]] Moment moment() const { return {clock_, ego_motion_}; }
  /// Time and world as they were: the same frame may be converted again.
  void rewind(const Moment& before);
  /// Makes the next frame a first one.
  void restart();

  [[nodiscard]] std::size_t memory_bytes() const;
  template <class State>
  void exchange(State& state) {
    state(clock_, ego_motion_);
  }

 private:
  Pose2 place(const StereoFrame& frame, double dt_s, FrameResult& result);
  [[nodiscard]] CameraView view(const Pose2& world_from_vehicle, double travelled_m) const;
  void level(const FrameImages& images, Cpu& cpu);

  Rig rig_;
  Levelling levelling_;
  FrameClock clock_;
  EgoMotion ego_motion_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
  Image<float> disparity_;
};

/// Throws ConfigError with all that a pipeline cannot be made of.
void check(const Config& config, const Rig& rig, const PipelineOptions& options);

/// Throws InputError where a frame's images, pose or other grids cannot be used.
void check(const StereoFrame& frame, const FrameImages& images, const Rig& rig);

/// Finite, and in a range with a resolution much finer than a cell.
bool is_place(const Pose2& pose);

}  // namespace stereogrid
