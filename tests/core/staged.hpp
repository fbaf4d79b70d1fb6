// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "chain_run.hpp"
#include "layouts/layouts.hpp"
#include "render/render.hpp"
#include "world/world.hpp"

namespace stereogrid::test {

/// Camera of the staged scenes: f·b = 56 px·m. With 64 disparities, surfaces nearer than 0.9 m cannot be matched.
inline Rig staged_rig() {
  return {.width_px = 320,
          .height_px = 200,
          .focal_px = 256,
          .cx_px = 160,
          .cy_px = 100,
          .baseline_m = 0.22,
          .camera_height_m = 1.25};
}

/// A drive whose poses are chosen frame by frame, at 10 Hz unless set otherwise.
class Staged {
 public:
  explicit Staged(scenes::World world, BackEnd back_end = BackEnd::cpu, const Config& config = preset("default"),
                  const Rig& rig = staged_rig())
      : rig_{rig}, world_{std::move(world)}, pipeline_{config, rig, {.back_end = back_end, .threads = 2}} {
    world_.road = scenes::two_lanes(3.5, 0);
  }

  /// The frame with the vehicle at (x_m, 0).
  StereoFrame frame_at(double x_m) {
    const Pose2 pose{x_m, 0, 0};
    const scenes::Frame3 vehicle{scenes::standing_at(world_.ground, pose, world_.wheels)};
    const auto parts = world_.at(time_s_);
    StereoFrame frame;
    frame.index = index_;
    frame.stamp_ns = std::llround(time_s_ * 1e9);
    frame.world_from_vehicle = pose;
    const auto seed = static_cast<std::uint64_t>(2 * index_);
    frame.left =
        render(world_, scenes::Caster{scenes::left_camera(rig_, vehicle), parts, world_.ground}, {1, 2.5, seed});
    frame.right = render(world_, scenes::Caster{scenes::right_camera(rig_, vehicle), parts, world_.ground},
                         {1.05, 2.5, seed + 1});
    ++index_;
    time_s_ += interval_s_;
    return frame;
  }
  const FrameResult& step(double x_m) { return pipeline_.process(frame_at(x_m)); }
  /// Frames from one place to another, both included.
  const FrameResult& drive(double from_m, double to_m, double step_m) {
    const int steps{static_cast<int>(std::lround(std::abs(to_m - from_m) / step_m))};
    const FrameResult* result{nullptr};
    for (int i{0}; i <= steps; ++i) result = &step(from_m + (to_m - from_m) * i / steps);
    return *result;
  }

  void set_interval(double interval_s) { interval_s_ = interval_s; }
  scenes::World& world() { return world_; }
  Pipeline& pipeline() { return pipeline_; }

 private:
  Rig rig_;
  scenes::World world_;
  Pipeline pipeline_;
  std::int64_t index_{0};
  double time_s_{0};
  double interval_s_{0.1};
};

}  // namespace stereogrid::test
