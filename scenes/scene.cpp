// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/scenes/scene.hpp"

#include <tbb/task_arena.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "layouts/layouts.hpp"
#include "render/render.hpp"
#include "stereogrid/error.hpp"
#include "truth/truth.hpp"
#include "world/numbers.hpp"

namespace stereogrid::scenes {
namespace {

Rig rig_of(const SceneOptions& options) {
  Rig rig;
  rig.width_px = options.width_px;
  rig.height_px = options.height_px;
  rig.focal_px = options.focal_px;
  rig.cx_px = options.width_px / 2.0;
  rig.cy_px = options.height_px / 2.0;
  rig.baseline_m = options.baseline_m;
  rig.camera_height_m = options.camera_height_m;
  rig.camera_pitch_rad = options.camera_pitch_rad;
  rig.camera_roll_rad = options.camera_roll_rad;
  return rig;
}

/// The rig as the suspension moves it in one frame.
Rig swayed(Rig rig, const SceneOptions& options, std::size_t index) {
  const auto draw = [&](std::uint64_t which) {
    return gaussian(scramble(options.seed ^ scramble(0x73776179U + 3 * index + which)));
  };
  rig.camera_pitch_rad += options.pitch_noise_rad * draw(0);
  rig.camera_roll_rad += options.roll_noise_rad * draw(1);
  rig.camera_height_m += options.height_noise_m * draw(2);
  return rig;
}

/// Everything that both cameras see at one instant.
struct Instant {
  Instant(const World& world, const Rig& of_instant, double time, const Pose2& place)
      : time_s{time},
        rig{of_instant},
        world_from_vehicle{place},
        vehicle{standing_at(world.ground, world_from_vehicle, world.wheels)},
        parts{world.at(time)},
        left{left_camera(rig, vehicle), parts, world.ground},
        right{right_camera(rig, vehicle), parts, world.ground} {}
  Instant(const Instant&) = delete;  // the casters refer to parts
  Instant& operator=(const Instant&) = delete;

  double time_s;
  Rig rig;
  Pose2 world_from_vehicle;
  Frame3 vehicle;
  std::vector<PlacedPart> parts;
  Caster left;
  Caster right;
};

}  // namespace

struct Scene::Implementation {
  Implementation(SceneOptions given, int threads)
      : options{completed(std::move(given))},
        rig{rig_of(options)},
        world{build_world(options)},
        arena{threads > 0 ? threads : tbb::task_arena::automatic} {}

  [[nodiscard]] Pose2 driven_pose(std::size_t index) const {
    return world.ego.pose_at(static_cast<double>(index) / options.rate_hz);
  }

  [[nodiscard]] Instant at(std::size_t index, const Pose2& place) const {
    if (index >= static_cast<std::size_t>(options.frames)) {
      throw InputError{"scene:" + options.name, "there is no frame " + std::to_string(index) + ".",
                       "It has " + std::to_string(options.frames) + "; ask for more with frames=N."};
    }
    return {world, swayed(rig, options, index), static_cast<double>(index) / options.rate_hz, place};
  }

  [[nodiscard]] Sensor sensor(std::size_t index, bool right) const {
    const std::uint64_t exposure{scramble(options.seed ^ scramble(2 * index + (right ? 1 : 0)))};
    return {right ? options.gain : 1.0, options.noise_grey, exposure};
  }

  SceneOptions options;
  Rig rig;
  World world;
  mutable tbb::task_arena arena;
};

Scene::Scene(SceneOptions options, int threads)
    : implementation_{std::make_unique<Implementation>(std::move(options), threads)} {}

Scene::~Scene() = default;

const Rig& Scene::rig() const {
  return implementation_->rig;
}

std::size_t Scene::size() const {
  return static_cast<std::size_t>(implementation_->options.frames);
}

std::string Scene::name(std::size_t index) const {
  char text[24];
  std::snprintf(text, sizeof text, "%06zu", index);
  return text;
}

const SceneOptions& Scene::options() const {
  return implementation_->options;
}

StereoFrame Scene::load(std::size_t index) const {
  return load(index, implementation_->driven_pose(index));
}

StereoFrame Scene::load(std::size_t index, const Pose2& world_from_vehicle) const {
  const Instant now{implementation_->at(index, world_from_vehicle)};
  StereoFrame frame;
  frame.name = name(index);
  frame.index = static_cast<std::int64_t>(index);
  frame.stamp_ns = std::llround(now.time_s * 1e9);
  frame.world_from_vehicle = now.world_from_vehicle;
  implementation_->arena.execute([&] {
    frame.left = render(implementation_->world, now.left, implementation_->sensor(index, false));
    frame.right = render(implementation_->world, now.right, implementation_->sensor(index, true));
  });
  return frame;
}

FrameTruth Scene::truth(std::size_t index) const {
  const Instant now{implementation_->at(index, implementation_->driven_pose(index))};
  const Moment moment{implementation_->world, now.rig, now.vehicle, now.parts, now.left, now.right, now.time_s};
  FrameTruth truth;
  implementation_->arena.execute([&] { truth = truth_of(moment, truth_grid()); });
  truth.name = name(index);
  truth.stamp_ns = std::llround(now.time_s * 1e9);
  return truth;
}

TruthGrid Scene::truth_grid() const {
  TruthGrid grid{{0, -10, 0.2, 100, 100}};
  if (implementation_->options.camera == "robot") grid = {{0, -3, 0.05, 120, 120}, 0.03, 0.5};
  grid.zones = implementation_->world.zones;
  return grid;
}

}  // namespace stereogrid::scenes
