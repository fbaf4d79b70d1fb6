// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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
  struct Tick {
    double dt_s{0};                     ///< 0: this frame is a first one
    std::optional<FrameStatus> leap{};  ///< clock_gap or clock_stepped_back: reset the state
    std::string warning{};              ///< message for the leap, without its consequence
  };
  /// True for the stamp of the frame before.
  [[nodiscard]] bool stands_still(std::int64_t stamp_ns) const { return last_ns_ && *last_ns_ == stamp_ns; }
  /// Advances to the next frame. A longer time than `gap_max_s` is a leap.
  Tick tick(std::int64_t stamp_ns, double gap_max_s);
  /// The next frame is a first one, whatever its stamp.
  void reset() { last_ns_.reset(); }

  template <class State>
  void exchange(State& state) {
    state(last_ns_);
  }

 private:
  std::optional<std::int64_t> last_ns_;
};

/// A camera's rig and level images.
class CameraInput {
 public:
  explicit CameraInput(const Rig& rig);

  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] const Rig& level_rig() const { return levelling_.level_rig(); }
  /// Pitch that levelling removes.
  [[nodiscard]] double turned_rad() const { return rig_.camera_pitch_rad - level_rig().camera_pitch_rad; }
  /// Sets the images of `frame`: views of `images` or of this object's images, until the next call.
  void set_images(const FrameImages& images, Cpu& cpu, LevelFrame& frame);
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  Rig rig_;
  Levelling levelling_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
  Image<float> disparity_;
};

/// A frame of a camera: index, stamp, pose and grids in `frame`, pixels in `images`.
struct CameraImages {
  const StereoFrame& frame;
  FrameImages images;
};

/// Converts stereo frames to the frame pipeline's input: time step, poses in the world, level images.
class FrameInput {
 public:
  FrameInput(const Config& config, std::span<const Rig> rigs, const PipelineOptions& options);

  [[nodiscard]] const CameraInput& camera(std::size_t index) const { return cameras_[index]; }
  [[nodiscard]] std::size_t cameras() const { return cameras_.size(); }
  /// Replaces a rig; time and world continue.
  void set_rig(std::size_t camera, const Rig& rig) { cameras_[camera] = CameraInput{rig}; }

  /// Throws InputError: a frame does not fit its rig, is one of two of a camera, or is not after those before.
  void check(std::span<const CameraImages> frames) const;
  /// The views are of the frames' images or of this object's images, until the next call. Sets status and warnings of
  /// clock and poses in `result`.
  const FrameSet& convert(std::span<const CameraImages> frames, Cpu& cpu, FrameResult& result);
  /// Clock of a camera, and place of its last frame.
  struct LastFrame {
    FrameClock clock{};
    Pose2 world_from_vehicle{};

    template <class State>
    void exchange(State& state) {
      state(clock, world_from_vehicle);
    }
  };
  /// Time and world between two frames.
  struct Moment {
    FrameClock clock;
    EgoMotion ego_motion;
    std::array<LastFrame, cameras_max> last{};
  };
  [[nodiscard]] const Moment& moment() const { return now_; }
  /// Time and world as they were: the same frame may be converted again.
  void rewind(const Moment& before) { now_ = before; }
  /// Makes the next frame a first one.
  void restart();

  [[nodiscard]] std::size_t memory_bytes() const;
  template <class State>
  void exchange(State& state) {
    state(now_.clock, now_.ego_motion);
    for (std::size_t i{0}; i < cameras_.size(); ++i) state(now_.last[i]);
  }

 private:
  void drop_last_frames() { std::ranges::fill(now_.last, LastFrame{}); }
  Pose2 place(const StereoFrame& frame, double dt_s, FrameResult& result);
  void add(const CameraImages& one, const StereoFrame& newest, Cpu& cpu, FrameResult& result);

  double gap_max_s_;
  double obstacle_min_height_m_;
  std::vector<CameraInput> cameras_;
  Moment now_;
  std::vector<LevelFrame> frames_;  // cameras of the last convert(); likewise the next two
  std::vector<CameraView> views_;
  FrameSet set_{};
};

/// Throws ConfigError with all that a pipeline cannot be made of.
void check(const Config& config, std::span<const Rig> rigs, const PipelineOptions& options);

/// "frame NAME" for messages, of one without a name its index.
inline std::string title_of(const StereoFrame& frame) {
  return "frame " + (frame.name.empty() ? std::to_string(frame.index) : frame.name);
}

/// Throws InputError where a frame's images, pose or other grids cannot be used.
void check(const StereoFrame& frame, const FrameImages& images, const Rig& rig);

/// Finite, and in a range with a resolution much finer than a cell.
bool is_place(const Pose2& pose);

}  // namespace stereogrid
