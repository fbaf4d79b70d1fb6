// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_input.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "geometry/composed.hpp"
#include "matching/checks/external.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

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

const StereoFrame& newest_of(std::span<const CameraImages> frames) {
  return std::ranges::max_element(frames, {}, [](const CameraImages& one) { return one.frame.stamp_ns; })->frame;
}

}  // namespace

FrameClock::Tick FrameClock::tick(std::int64_t stamp_ns, double gap_max_s) {
  const std::optional<std::int64_t> last_ns{std::exchange(last_ns_, stamp_ns)};
  if (!last_ns) return {};
  if (stamp_ns < *last_ns) {
    return {0, FrameStatus::clock_stepped_back,
            "the clock has stepped back by " + text_of(seconds_between(stamp_ns, *last_ns))};
  }
  const double dt_s{seconds_between(*last_ns, stamp_ns)};
  if (dt_s <= gap_max_s) return {dt_s, {}, {}};
  return {0, FrameStatus::clock_gap, text_of(dt_s) + " since the frame before, more than motion.gap_max_s"};
}

CameraInput::CameraInput(const Rig& rig)
    : rig_{rig},
      levelling_{rig},
      left_{level_rig().width_px, level_rig().height_px},
      right_{left_},
      disparity_{level_rig().width_px, level_rig().height_px} {}

void CameraInput::set_images(const FrameImages& images, Cpu& cpu, LevelFrame& frame) {
  frame.left = images.left;
  frame.right = images.right;
  frame.disparity = images.disparity;
  frame.disparity_step_px = step_of(images.disparity);
  if (!levelling_.is_needed()) return;
  levelling_.apply(cpu, images.left, left_.view());
  frame.left = left_.view();
  if (!images.right.empty()) {
    levelling_.apply(cpu, images.right, right_.view());
    frame.right = right_.view();
  }
  if (!images.disparity.empty()) {
    levelling_.apply(cpu, images.disparity, disparity_.view());
    frame.disparity = disparity_.view();
  }
}

std::size_t CameraInput::memory_bytes() const {
  return memory_bytes_of(left_, right_, disparity_);
}

namespace {

// Distance ahead from which on the level image shows things of that height.
double nearest_seen_m(const Rig& level, double height_m) {
  const double rows{level.height_px - 1 - (level.cy_px - level.focal_px * std::tan(level.camera_pitch_rad))};
  const double above_m{std::max(level.camera_height_m - height_m, 0.0)};
  if (above_m > 0 && rows <= 0) return std::numeric_limits<double>::infinity();
  return above_m * level.focal_px / std::max(rows, 1.0);
}

}  // namespace

FrameInput::FrameInput(const Config& config, std::span<const Rig> rigs, const PipelineOptions& options)
    : gap_max_s_{config.motion.gap_max_s},
      obstacle_min_height_m_{config.u_disparity.obstacle_min_height_m},
      cameras_(rigs.begin(), rigs.end()),
      now_{{}, EgoMotion{config.motion, options.in_world_of_poses}} {
  now_.ego_motion.start_at(options.start);
  frames_.reserve(rigs.size());
  views_.reserve(rigs.size());
}

void FrameInput::check(std::span<const CameraImages> frames) const {
  if (frames.empty()) throw InputError{"frame", "there is none.", "Give a frame of one camera at least."};
  std::uint64_t seen{0};
  for (const auto& [frame, images] : frames) {
    const auto refuse = [&frame = frame](const std::string& problem, const char* remedy) {
      throw InputError{title_of(frame), problem, remedy};
    };
    if (frame.camera < 0 || frame.camera >= static_cast<int>(cameras_.size())) {
      refuse("its camera is " + std::to_string(frame.camera) + " (allowed 0 … " + std::to_string(cameras_.size() - 1) +
                 ").",
             "The camera is an index into the pipeline's rigs.");
    }
    const auto camera = static_cast<std::size_t>(frame.camera);
    if ((seen >> camera & 1U) != 0) refuse("is the second one of its camera.", "Give one frame of a camera at a time.");
    seen |= std::uint64_t{1} << camera;
    stereogrid::check(frame, images, cameras_[camera].rig());
    if (now_.last[camera].clock.stands_still(frame.stamp_ns)) {
      refuse("its stamp is that of the frame before.", "Every frame needs a stamp of its own.");
    }
  }
  const StereoFrame& newest{newest_of(frames)};
  if (now_.clock.stands_still(newest.stamp_ns)) {
    throw InputError{title_of(newest), "its stamp is that of the frame before.",
                     "Every frame needs a stamp of its own."};
  }
}

// The vehicle is where it was at the newest frame. The camera of another frame is moved by the difference of the poses.
void FrameInput::add(const CameraImages& one, const StereoFrame& newest, Cpu& cpu, FrameResult& result) {
  const StereoFrame& frame{one.frame};
  const auto index = static_cast<std::size_t>(frame.camera);
  CameraInput& camera{cameras_[index]};
  LastFrame& last{now_.last[index]};
  const bool has_moved{&frame != &newest && newest.world_from_vehicle && frame.world_from_vehicle};
  const Pose2 vehicle{has_moved
                          ? set_.world_from_vehicle * (inverse(*newest.world_from_vehicle) * *frame.world_from_vehicle)
                          : set_.world_from_vehicle};
  LevelFrame level{};
  level.world_from_camera = composed(vehicle, camera_place(camera.rig()));
  level.camera = frame.camera;
  FrameClock::Tick tick{last.clock.tick(frame.stamp_ns, gap_max_s_)};
  const auto named = [&](const std::string& text) { return result.cameras[index].camera_name + ": " + text; };
  if (tick.leap) result.add(*tick.leap, named(tick.warning + ": the state of this camera is reset"));
  if (const double age_s{seconds_between(frame.stamp_ns, newest.stamp_ns)}; set_.dt_s > 0 && age_s > set_.dt_s) {
    result.warnings.push_back({named("its frame is " + text_of(age_s) +
                                     " older than the newest, and older than the result before. Check the clocks.")});
  }
  level.restarts = set_.restarts || tick.leap;
  level.dt_s = tick.dt_s;
  camera.set_images(one.images, cpu, level);
  frames_.push_back(level);
  const double travelled_m{
      level.dt_s > 0 && frame.world_from_vehicle
          ? std::hypot(vehicle.x_m - last.world_from_vehicle.x_m, vehicle.y_m - last.world_from_vehicle.y_m)
          : std::numeric_limits<double>::infinity()};
  const Rig& rig{camera.rig()};
  const double focal_baseline_pxm{rig.focal_px * rig.baseline_m};
  const bool is_alone{newest.other_grids.empty()};  // else another source sees what the camera overlooks
  views_.push_back({level.world_from_camera, rig.cx_px / rig.focal_px, (rig.width_px - rig.cx_px) / rig.focal_px,
                    focal_baseline_pxm * travelled_m, focal_baseline_pxm,
                    is_alone ? nearest_seen_m(camera.level_rig(), obstacle_min_height_m_) : 0,
                    is_alone ? rig.baseline_m : 0});
  last.world_from_vehicle = vehicle;
}

const FrameSet& FrameInput::convert(std::span<const CameraImages> frames, Cpu& cpu, FrameResult& result) {
  const StereoFrame& newest{newest_of(frames)};
  FrameClock::Tick tick{now_.clock.tick(newest.stamp_ns, gap_max_s_)};
  if (tick.leap) {
    now_.ego_motion.restart();
    drop_last_frames();
    result.add(*tick.leap, tick.warning + ": all state is reset");
  }
  const double dt_s{tick.dt_s};
  constexpr double shortest_s{1e-3};
  if (dt_s > 0 && dt_s < shortest_s) {
    result.warnings.push_back({"the stamp is only " + text_of_ns(dt_s) +
                               " after that of the frame before: stamp_ns is "
                               "in nanoseconds. Convert it from seconds, milliseconds or microseconds."});
  }
  frames_.clear();
  views_.clear();
  set_ = {{}, place(newest, dt_s, result), dt_s, newest.other_grids, {}, tick.leap.has_value()};
  for (std::size_t camera{0}; camera < cameras_.size(); ++camera) {
    const auto has_camera = [camera](const CameraImages& one) { return one.frame.camera == static_cast<int>(camera); };
    const auto one = std::ranges::find_if(frames, has_camera);
    if (one != frames.end()) add(*one, newest, cpu, result);
  }
  set_.cameras = frames_;
  set_.views = views_;
  return set_;
}

Pose2 FrameInput::place(const StereoFrame& frame, double dt_s, FrameResult& result) {
  EgoMotion::Placing placing{now_.ego_motion.place(frame.world_from_vehicle, dt_s)};
  if (placing.status) result.add(*placing.status, std::move(placing.warning));
  return placing.world_from_vehicle;
}

void FrameInput::restart() {
  now_.clock.reset();
  now_.ego_motion.restart();
  drop_last_frames();
}

std::size_t FrameInput::memory_bytes() const {
  return memory_bytes_of(cameras_, frames_, views_);
}

}  // namespace stereogrid
