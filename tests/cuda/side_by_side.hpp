// SPDX-License-Identifier: Apache-2.0
//
// Frame pipeline on the GPU and on the reference back end, side by side.
#pragma once

#include <memory>
#include <utility>

#include "backend/cpu.hpp"
#include "check.hpp"
#include "images.hpp"
#include "pipeline/cuda/stages.hpp"
#include "pipeline/frame_pipeline.hpp"
#include "pipeline/results.hpp"
#include "street.hpp"

namespace stereogrid::test {

inline constexpr int width{125};
inline constexpr int height{86};

inline Config small_config() {
  Config config{preset("default")};
  config.grid = {10, 8, 0.5};
  config.matching.disparities = 16;
  config.matching.speckle_px = config.matching.road_speckle_px = 20;
  config.filter.speeds_mps = {1.25, 2.5, 3.9};
  return config;
}

inline std::unique_ptr<Stages> law_stages(const Config& config, const Rig& rig, const PixelMask& mask = {}) {
  static Cpu cpu{1};
  return reference_stages(config, rig, cpu, {.mask = mask});
}

/// A frame pipeline and its last result.
struct Runner {
  Runner(std::unique_ptr<Stages> stages, const Config& config, const Rig& rig, GroundMode mode = GroundMode::given)
      : frames{config, rig, cpu, std::move(stages), 0, mode}, result{empty_result(config, rig)} {}

  void run(const StereoFrame& frame, double dt_s) {
    result.status.clear();
    result.warnings.clear();
    const LevelFrame level{frame.left.view(), frame.right.view(), frame.disparity.view(), *frame.world_from_vehicle,
                           dt_s};
    const auto replaced = frames.process({{&level, 1}, level.world_from_camera, dt_s, frame.other_grids}, result);
    found = replaced.empty() ? std::optional<Ground>{} : replaced.front().ground;
  }

  Cpu cpu{1};
  FramePipeline frames;
  FrameResult result;
  std::optional<Ground> found;  ///< extrinsics that replace the rig's
};

inline void compare(const StageImages& gpu, const StageImages& law) {
  CHECK_EQUAL(differences(gpu.obstacle_disparity, law.obstacle_disparity), 0);
  CHECK_EQUAL(differences(gpu.road_disparity, law.road_disparity), 0);
  CHECK_EQUAL(differences(gpu.match_confidence, law.match_confidence), 0);
  CHECK_EQUAL(differences(gpu.ambiguous, law.ambiguous), 0);
  CHECK(gpu.possible == law.possible);
  CHECK_EQUAL(differences(gpu.visible, law.visible), 0);
  CHECK_EQUAL(differences(gpu.observed, law.observed), 0);
  CHECK_EQUAL(differences(gpu.visibility, law.visibility), 0);
  CHECK_EQUAL(differences(gpu.obstacle_confidence, law.obstacle_confidence), 0);
  CHECK_EQUAL(differences(gpu.road_confidence, law.road_confidence), 0);
  CHECK_EQUAL(differences(gpu.occupancy, law.occupancy), 0);
  CHECK_EQUAL(differences(gpu.occupancy_smooth, law.occupancy_smooth), 0);
}

inline void compare(const Ground& gpu, const Ground& law) {
  CHECK_EQUAL(gpu.estimated, law.estimated);
  CHECK_EQUAL(gpu.height_m, law.height_m);
  CHECK_EQUAL(gpu.pitch_rad, law.pitch_rad);
  CHECK_EQUAL(gpu.roll_rad, law.roll_rad);
  CHECK_EQUAL(gpu.height_sigma_m, law.height_sigma_m);
  CHECK_EQUAL(gpu.pitch_sigma_rad, law.pitch_sigma_rad);
  CHECK_EQUAL(gpu.roll_sigma_rad, law.roll_sigma_rad);
  CHECK(gpu == law);  // and correlations
}

// tay2008's sum over all velocities is formed in another order (filter/cuda.hpp); its results are divided by it.
inline void compare_nearly(const FrameResult& gpu, const FrameResult& law) {
  constexpr double bound{1e-5};
  compare(gpu.stages, law.stages);
  CHECK_EQUAL(differences(gpu.observed, law.observed), 0);
  CHECK_EQUAL(differences(gpu.world.age_s, law.world.age_s), 0);
  CHECK_NEAR(largest_difference(gpu.world.occupancy, law.world.occupancy), 0, bound);
  CHECK_NEAR(largest_difference(gpu.world.velocity_x, law.world.velocity_x), 0, bound);
  CHECK_NEAR(largest_difference(gpu.vehicle.occupancy, law.vehicle.occupancy), 0, bound);
  CHECK_EQUAL(gpu.obstacles.size(), law.obstacles.size());
}

inline void compare_grids(const FrameResult& gpu, const FrameResult& law) {
  CHECK_EQUAL(differences(gpu.observed, law.observed), 0);
  CHECK(gpu.world.geometry == law.world.geometry);
  CHECK_EQUAL(differences(gpu.world.occupancy, law.world.occupancy), 0);
  CHECK_EQUAL(differences(gpu.world.age_s, law.world.age_s), 0);
  CHECK_EQUAL(differences(gpu.world.velocity_x, law.world.velocity_x), 0);
  CHECK_EQUAL(differences(gpu.world.velocity_xy, law.world.velocity_xy), 0);
  CHECK_EQUAL(differences(gpu.vehicle.occupancy, law.vehicle.occupancy), 0);
  CHECK_EQUAL(differences(gpu.vehicle.velocity_y, law.vehicle.velocity_y), 0);
  CHECK_EQUAL(differences(gpu.vehicle.moving, law.vehicle.moving), 0);
  CHECK_EQUAL(differences(gpu.vehicle.age_s, law.vehicle.age_s), 0);
  CHECK_EQUAL(differences(gpu.terrain, law.terrain), 0);
  CHECK_EQUAL(differences(gpu.witness, law.witness), 0);
  CHECK_EQUAL(differences(gpu.world_terrain, law.world_terrain), 0);
  CHECK_EQUAL(gpu.obstacles.size(), law.obstacles.size());
  for (std::size_t i{0}; i < gpu.obstacles.size() && i < law.obstacles.size(); ++i) {
    CHECK_EQUAL(gpu.obstacles[i].id, law.obstacles[i].id);
    CHECK_EQUAL(gpu.obstacles[i].x_m, law.obstacles[i].x_m);
    CHECK_EQUAL(gpu.obstacles[i].vx_mps, law.obstacles[i].vx_mps);
  }
}

inline void compare(const FrameResult& gpu, const FrameResult& law) {
  compare(gpu.stages, law.stages);
  compare(gpu.ground, law.ground);
  compare_grids(gpu, law);
  CHECK_EQUAL(gpu.obstacle_density, law.obstacle_density);
  CHECK_EQUAL(gpu.road_density, law.road_density);
  CHECK(gpu.status == law.status);
  CHECK(gpu.warnings == law.warnings);
}

/// The device has the grids of the result.
inline void compare_on_device(FramePipeline& frames, const FrameResult& result) {
  Cuda cuda;
  const auto compare_next = [&cuda](const float*& on_device, const Image<float>& expected) {
    Image<float> found{expected.width(), expected.height()};
    download(cuda, on_device, found.size(), found.data());
    cuda.synchronize();
    CHECK_EQUAL(differences(found, expected), 0);
    on_device += found.size();
  };
  DeviceGrids grids{frames.device_grids()};
  compare_next(grids.observed, result.observed);
  const auto compare_layers = [&](const float* on_device, const GridLayers& layers) {
    for (const Image<float>* layer : {&layers.occupancy, &layers.velocity_x, &layers.velocity_y, &layers.age_s,
                                      &layers.velocity_xx, &layers.velocity_xy, &layers.velocity_yy, &layers.moving})
      compare_next(on_device, *layer);
  };
  compare_layers(grids.vehicle, result.vehicle);
  compare_layers(grids.world, result.world);
}

/// Both back ends side by side.
class Pair {
 public:
  Pair(const Config& config, const Rig& rig, const PixelMask& mask = {}, GroundMode mode = GroundMode::given)
      : gpu{std::make_unique<CudaStages>(config, rig, 0, StagesOptions{.mask = mask}), config, rig, mode},
        law{law_stages(config, rig, mask), config, rig, mode} {}

  void run(const StereoFrame& frame) {
    const double dt_s{frame.index == 0 ? 0 : 0.1};
    gpu.run(frame, dt_s);
    law.run(frame, dt_s);
    is_equal_to_the_bit ? compare(gpu.result, law.result) : compare_nearly(gpu.result, law.result);
    compare_on_device(gpu.frames, gpu.result);
  }

  Runner gpu;
  Runner law;
  bool is_equal_to_the_bit{true};
};

inline Rig small_rig() {
  return Street::rig(width, height);
}

}  // namespace stereogrid::test
