// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_input.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "matching/checks/external.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr const char* consequence{"all state is reset"};

// Unsigned, since from one end of the stamps to the other is more than a signed number holds.
double seconds_between(std::int64_t earlier_ns, std::int64_t later_ns) {
  return static_cast<double>(static_cast<std::uint64_t>(later_ns) - static_cast<std::uint64_t>(earlier_ns)) * 1e-9;
}

std::string text_of(double seconds) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f s", seconds);
  return text.data();
}

std::string text_of_ns(double seconds) {
  return std::to_string(std::llround(seconds * 1e9)) + " ns";
}

}  // namespace

FrameClock::Tick FrameClock::tick(std::int64_t stamp_ns) {
  const std::optional<std::int64_t> last_ns{std::exchange(last_ns_, stamp_ns)};
  if (!last_ns) return {};
  if (stamp_ns < *last_ns) {
    return {0, FrameStatus::clock_stepped_back,
            "the clock has stepped back by " + text_of(seconds_between(stamp_ns, *last_ns)) + ": " + consequence};
  }
  const double dt_s{seconds_between(*last_ns, stamp_ns)};
  if (dt_s <= gap_max_s_) return {dt_s, {}, {}};
  return {0, FrameStatus::clock_gap,
          text_of(dt_s) + " since the frame before, more than motion.gap_max_s: " + consequence};
}

FrameInput::FrameInput(const MotionConfig& config, const Rig& rig, const PipelineOptions& options)
    : rig_{rig}, levelling_{rig}, clock_{config.gap_max_s}, ego_motion_{config, options.in_world_of_poses} {
  set_rig(rig);
  ego_motion_.start_at(options.start);
}

void FrameInput::set_rig(const Rig& rig) {
  Levelling levelling{rig};
  const Rig& level_rig{levelling.level_rig()};
  Image<std::uint8_t> left{level_rig.width_px, level_rig.height_px};
  Image<std::uint8_t> right{left};
  Image<float> disparity{level_rig.width_px, level_rig.height_px};
  left_ = std::move(left);
  right_ = std::move(right);
  disparity_ = std::move(disparity);
  levelling_ = levelling;
  rig_ = rig;
}

void FrameInput::check(const StereoFrame& frame, const FrameImages& images) const {
  stereogrid::check(frame, images, rig_);
  if (clock_.stands_still(frame.stamp_ns)) {
    throw InputError{"frame " + frame.name, "its stamp is that of the frame before.",
                     "Every frame needs a stamp of its own."};
  }
}

LevelFrame FrameInput::convert(const StereoFrame& frame, const FrameImages& images, Cpu& cpu, FrameResult& result) {
  FrameClock::Tick tick{clock_.tick(frame.stamp_ns)};
  if (tick.leap) {
    ego_motion_.restart();
    result.add(*tick.leap, std::move(tick.warning));
  }
  const double dt_s{tick.dt_s};
  constexpr double shortest_s{1e-3};
  if (dt_s > 0 && dt_s < shortest_s) {
    result.warnings.push_back({"the stamp is only " + text_of_ns(dt_s) +
                               " after that of the frame before: stamp_ns is "
                               "in nanoseconds. Convert it from seconds, milliseconds or microseconds."});
  }
  const Pose2 before{ego_motion_.world_from_vehicle()};
  const Pose2 pose{place(frame, dt_s, result)};
  const double travelled_m{dt_s > 0 && frame.world_from_vehicle
                               ? std::hypot(pose.x_m - before.x_m, pose.y_m - before.y_m)
                               : std::numeric_limits<double>::infinity()};
  LevelFrame converted{images.left, images.right,      images.disparity,       pose,
                       dt_s,        frame.other_grids, view(pose, travelled_m)};
  converted.restarts = tick.leap.has_value();
  converted.disparity_step_px = step_of(images.disparity);
  if (!levelling_.is_needed()) return converted;
  level(images, cpu);
  converted.left = left_.view();
  if (!converted.right.empty()) converted.right = right_.view();
  if (converted.has_external_disparity()) converted.disparity = disparity_.view();
  return converted;
}

Pose2 FrameInput::place(const StereoFrame& frame, double dt_s, FrameResult& result) {
  EgoMotion::Placing placing{ego_motion_.place(frame.world_from_vehicle, dt_s)};
  if (placing.status) result.add(*placing.status, std::move(placing.warning));
  return placing.world_from_vehicle;
}

CameraView FrameInput::view(const Pose2& world_from_vehicle, double travelled_m) const {
  const double focal_baseline_pxm{rig_.focal_px * rig_.baseline_m};
  return {world_from_vehicle, rig_.cx_px / rig_.focal_px, (rig_.width_px - rig_.cx_px) / rig_.focal_px,
          focal_baseline_pxm * travelled_m, focal_baseline_pxm};
}

void FrameInput::level(const FrameImages& images, Cpu& cpu) {
  levelling_.apply(cpu, images.left, left_.view());
  if (!images.right.empty()) levelling_.apply(cpu, images.right, right_.view());
  if (!images.disparity.empty()) levelling_.apply(cpu, images.disparity, disparity_.view());
}

void FrameInput::rewind(const Moment& before) {
  clock_ = before.clock;
  ego_motion_ = before.ego_motion;
}

void FrameInput::restart() {
  clock_.reset();
  ego_motion_.restart();
}

std::size_t FrameInput::memory_bytes() const {
  return memory_bytes_of(left_, right_, disparity_);
}

}  // namespace stereogrid
