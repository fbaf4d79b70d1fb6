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

Rig rig_of(const SceneOptions& options, int camera) {
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
  if (options.cameras == 1) return rig;
  rig.camera_yaw_rad = std::remainder(camera * options.turn_deg * pi / 180, 2 * pi);
  const auto to_micrometres = [](double m) { return std::round(m * 1e6) / 1e6 + 0.0; };
  rig.camera_x_m = to_micrometres(options.ring_m * std::cos(rig.camera_yaw_rad));
  rig.camera_y_m = to_micrometres(options.ring_m * std::sin(rig.camera_yaw_rad));
  return rig;
}

std::vector<Rig> rigs_of(const SceneOptions& options) {
  std::vector<Rig> rigs;
  for (int camera{0}; camera < options.cameras; ++camera) rigs.push_back(rig_of(options, camera));
  return rigs;
}

/// The frame on the ground below a camera that is fixed to the vehicle.
Frame3 below_camera(const Rig& rig, const Frame3& vehicle) {
  if (camera_place(rig) == Pose2{}) return vehicle;
  const double c{std::cos(rig.camera_yaw_rad)};
  const double s{std::sin(rig.camera_yaw_rad)};
  return {vehicle.back({rig.camera_x_m, rig.camera_y_m, 0}), c * vehicle.forward + s * vehicle.left,
          c * vehicle.left - s * vehicle.forward, vehicle.up};
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

/// A stereo pair at one instant.
struct Pair {
  Pair(const World& world, const Rig& of_instant, const Frame3& vehicle, const std::vector<PlacedPart>& parts)
      : rig{of_instant},
        left{left_camera(rig, below_camera(rig, vehicle)), parts, world.ground},
        right{right_camera(rig, below_camera(rig, vehicle)), parts, world.ground} {}

  Rig rig;
  Caster left;
  Caster right;
};

/// Everything that all cameras see at one instant.
struct Instant {
  Instant(const World& world, const std::vector<Rig>& rigs, double time, const Pose2& place)
      : time_s{time},
        world_from_vehicle{place},
        vehicle{standing_at(world.ground, world_from_vehicle, world.wheels)},
        parts{world.at(time)} {
    for (const Rig& rig : rigs) pairs.emplace_back(world, rig, vehicle, parts);
  }
  Instant(const Instant&) = delete;  // the casters refer to parts
  Instant& operator=(const Instant&) = delete;

  double time_s;
  Pose2 world_from_vehicle;
  Frame3 vehicle;
  std::vector<PlacedPart> parts;
  std::vector<Pair> pairs;
};

}  // namespace

struct Scene::Implementation {
  Implementation(SceneOptions given, int threads)
      : options{completed(std::move(given))},
        rigs{rigs_of(options)},
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
    std::vector<Rig> now;
    for (const Rig& rig : rigs) now.push_back(swayed(rig, options, index));
    return {world, now, static_cast<double>(index) / options.rate_hz, place};
  }

  /// A camera's frame, but for its images.
  [[nodiscard]] StereoFrame frame(std::size_t index, const Instant& now, int camera) const {
    StereoFrame frame;
    char name[24];
    std::snprintf(name, sizeof name, "%06zu", index);
    frame.name = name;
    frame.index = static_cast<std::int64_t>(index);
    frame.stamp_ns = std::llround(now.time_s * 1e9);
    frame.world_from_vehicle = now.world_from_vehicle;
    frame.camera = camera;
    return frame;
  }

  [[nodiscard]] Sensor sensor(std::size_t index, int camera, bool right) const {
    const std::uint64_t of_camera{camera == 0 ? 0 : scramble(0x63616d73U + static_cast<unsigned>(camera))};
    const std::uint64_t exposure{scramble(options.seed ^ of_camera ^ scramble(2 * index + (right ? 1 : 0)))};
    return {right ? options.gain : 1.0, options.noise_grey, exposure};
  }

  void render_into(const Instant& now, StereoFrame& frame) const {
    const Pair& pair{now.pairs[static_cast<std::size_t>(frame.camera)]};
    const auto index = static_cast<std::size_t>(frame.index);
    frame.left = render(world, pair.left, sensor(index, frame.camera, false));
    frame.right = render(world, pair.right, sensor(index, frame.camera, true));
  }

  SceneOptions options;
  std::vector<Rig> rigs;
  World world;
  mutable tbb::task_arena arena;
};

Scene::Scene(SceneOptions options, int threads)
    : implementation_{std::make_unique<Implementation>(std::move(options), threads)} {}

Scene::~Scene() = default;

const Rig& Scene::rig() const {
  return implementation_->rigs.front();
}

std::span<const Rig> Scene::rigs() const {
  return implementation_->rigs;
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
  const Implementation& self{*implementation_};
  const Instant now{self.at(index, world_from_vehicle)};
  StereoFrame frame{self.frame(index, now, 0)};
  for (int camera{1}; camera < self.options.cameras; ++camera) frame.others.push_back(self.frame(index, now, camera));
  self.arena.execute([&] {
    self.render_into(now, frame);
    for (StereoFrame& other : frame.others) self.render_into(now, other);
  });
  return frame;
}

FrameTruth Scene::truth(std::size_t index) const {
  const Instant now{implementation_->at(index, implementation_->driven_pose(index))};
  const Pair& first{now.pairs.front()};
  Moment moment{implementation_->world, first.rig, now.vehicle, now.parts, first.left, first.right, now.time_s};
  for (std::size_t i{1}; i < now.pairs.size(); ++i) moment.other_lefts.push_back(&now.pairs[i].left);
  FrameTruth truth;
  implementation_->arena.execute([&] { truth = truth_of(moment, truth_grid()); });
  truth.name = name(index);
  truth.stamp_ns = std::llround(now.time_s * 1e9);
  return truth;
}

TruthGrid Scene::truth_grid() const {
  TruthGrid grid{{0, -10, 0.2, 100, 100}};
  if (implementation_->options.camera == "robot") grid = {{0, -3, 0.05, 120, 120}, 0.03, 0.5};
  if (implementation_->options.cameras > 1) {
    grid.geometry.x_min_m = -grid.geometry.nx * grid.geometry.cell_size_m / 2;
    grid.geometry.y_min_m = -grid.geometry.ny * grid.geometry.cell_size_m / 2;
  }
  grid.zones = implementation_->world.zones;
  return grid;
}

}  // namespace stereogrid::scenes
