// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "check.hpp"
#include "ground/cuda.hpp"
#include "ground/ground.hpp"
#include "images.hpp"

namespace stereogrid::test {
namespace {

constexpr double dt_s{0.1};

struct Street {
  Image<float> obstacle;
  Image<float> road;
};

// Matches of an endless road, with noise, outliers and a van that hides most of the road ahead.
Street street(const Rig& rig, const Ground& truth, Random& random) {
  const RoadPlane plane{road_plane(rig, truth)};
  Street seen{Image<float>{rig.width_px, rig.height_px}, Image<float>{rig.width_px, rig.height_px}};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double d{plane.disparity(u, v)};
      if (u > rig.width_px / 3 && u < rig.width_px * 2 / 3 && v > rig.height_px / 5 && d < 9) {
        seen.obstacle(u, v) = 9;
      } else if (d >= 1) {
        const double outlier{random.happens(0.2) ? random.between(-3, 30) : 0};
        const double noise{random.between(-0.4, 0.4) + random.between(-0.4, 0.4)};
        seen.road(u, v) = static_cast<float>(std::max(d + noise + outlier, 0.0));
      }
    }
  }
  return seen;
}

struct Found {
  Ground ground;
  bool is_lost;
};

Found on_cpu(const Rig& rig, const GroundConfig& config, const Street& seen, const Ground& previous) {
  GroundSpace space{rig.width_px, rig.height_px};
  return {estimate_ground(rig, config, seen.road.view(), previous, dt_s, space),
          is_lost(rig, config, seen.obstacle.view(), seen.road.view(), previous, space)};
}

Found on_gpu(const Rig& rig, const GroundConfig& config, const Street& seen, const Ground& previous) {
  Cuda cuda;
  const DeviceImage<float> obstacle{on_device(cuda, seen.obstacle)};
  const DeviceImage<float> road{on_device(cuda, seen.road)};
  const DeviceBuffer<GroundPrior> prior{one_on_device(cuda, prior_of(rig, config, previous, dt_s))};
  GroundOnDevice space{rig.width_px, rig.height_px};
  DeviceBuffer<Ground> ground{1};
  DeviceBuffer<int> lost{1};
  estimate_ground(cuda, rig, config, obstacle.view(), road.view(), prior.data(), space, ground.data(), lost.data());
  return {first_on_host(cuda, ground), first_on_host(cuda, lost) != 0};
}

// One step of `rounded` (ground/fit_model.hpp).
constexpr double bound{1.01 / (1 << 20)};
constexpr double correlation_bound{1.01 / (1 << 12)};

int grounds_off{0};

void check_equal(const Found& gpu, const Found& cpu) {
  CHECK_EQUAL(gpu.is_lost, cpu.is_lost);
  CHECK_EQUAL(gpu.ground.estimated, cpu.ground.estimated);
  CHECK_NEAR(gpu.ground.height_m, cpu.ground.height_m, bound);
  CHECK_NEAR(gpu.ground.pitch_rad, cpu.ground.pitch_rad, bound);
  CHECK_NEAR(gpu.ground.roll_rad, cpu.ground.roll_rad, bound);
  CHECK_NEAR(gpu.ground.height_sigma_m, cpu.ground.height_sigma_m, bound);
  CHECK_NEAR(gpu.ground.pitch_sigma_rad, cpu.ground.pitch_sigma_rad, bound);
  CHECK_NEAR(gpu.ground.roll_sigma_rad, cpu.ground.roll_sigma_rad, bound);
  CHECK_NEAR(gpu.ground.height_pitch_correlation, cpu.ground.height_pitch_correlation, correlation_bound);
  CHECK_NEAR(gpu.ground.height_roll_correlation, cpu.ground.height_roll_correlation, correlation_bound);
  CHECK_NEAR(gpu.ground.pitch_roll_correlation, cpu.ground.pitch_roll_correlation, correlation_bound);
  if (!(gpu.ground == cpu.ground)) ++grounds_off;
}

Rig rig_of(int width, int height) {
  return {width, height, 0.58 * width, 0.49 * width, 0.46 * height, 0.54, 1.65, 0.01, 0};
}

TEST(ground_is_that_of_the_cpu) {
  Random random{11};
  for (int round{0}; round < 6; ++round) {
    const Rig rig{rig_of(311 + 2 * round, 141 + round)};
    const Ground truth{1.65 + random.between(-0.1, 0.1), random.between(-0.02, 0.04), random.between(-0.04, 0.04)};
    const Street seen{street(rig, truth, random)};
    const GroundConfig config;
    const Found cpu{on_cpu(rig, config, seen, calibrated_ground(rig, config))};
    check_equal(on_gpu(rig, config, seen, calibrated_ground(rig, config)), cpu);
    CHECK(cpu.ground.estimated);
    CHECK_NEAR(cpu.ground.height_m, truth.height_m, 0.1);
    const Found again{on_cpu(rig, config, seen, cpu.ground)};  // and from a sure one
    check_equal(on_gpu(rig, config, seen, cpu.ground), again);
  }
  CHECK(grounds_off <= 1);
}

TEST(ground_is_lost_where_the_road_lies_elsewhere) {
  Random random{13};
  const Rig rig{rig_of(320, 160)};
  const GroundConfig config;
  const Street seen{street(rig, {1.65, 0.07, 0}, random)};
  const Found cpu{on_cpu(rig, config, seen, calibrated_ground(rig, config))};
  check_equal(on_gpu(rig, config, seen, calibrated_ground(rig, config)), cpu);
  CHECK(cpu.is_lost);
}

// Just below the horizon pixels count for is_lost, though the fit does not read them there; above it none does.
TEST(ground_is_lost_from_the_horizon_on) {
  const Rig rig{rig_of(320, 160)};
  const GroundConfig config;
  const Ground expected{calibrated_ground(rig, config)};
  const RoadPlane plane{road_plane(rig, expected)};
  for (const bool is_below : {true, false}) {
    Street seen{Image<float>{320, 160}, Image<float>{320, 160}};
    for (int v{0}; v < 160; ++v) {
      for (int u{0}; u < 320; ++u) {
        const double d{plane.disparity(u, v)};
        if (is_below ? d > 0 && d < 3.5 : d < -1.5) seen.obstacle(u, v) = static_cast<float>(std::max(d, 0.5) + 6);
      }
    }
    const Found cpu{on_cpu(rig, config, seen, expected)};
    check_equal(on_gpu(rig, config, seen, expected), cpu);
    CHECK_EQUAL(cpu.is_lost, is_below);
  }
}

TEST(ground_without_road_is_carried_over) {
  const Rig rig{rig_of(97, 61)};
  const GroundConfig config;
  const Street nothing{Image<float>{97, 61}, Image<float>{97, 61}};
  const Found gpu{on_gpu(rig, config, nothing, calibrated_ground(rig, config))};
  check_equal(gpu, on_cpu(rig, config, nothing, calibrated_ground(rig, config)));
  CHECK(!gpu.ground.estimated);
  CHECK(gpu.ground.height_sigma_m > 0);
}

TEST(ground_is_trusted_where_it_is_not_to_be_estimated) {
  Random random{17};
  const Rig rig{rig_of(160, 90)};
  GroundConfig config;
  config.estimate = false;
  const Ground previous{1.5, 0.02, -0.01, true};
  const Found gpu{on_gpu(rig, config, street(rig, {1.6, 0.03, 0}, random), previous)};
  CHECK(!gpu.is_lost);
  CHECK(!gpu.ground.estimated);
  CHECK_EQUAL(gpu.ground.height_m, 1.5);
  CHECK_EQUAL(gpu.ground.roll_rad, -0.01);
}

TEST(ground_of_the_smallest_images) {
  for (const int size : {1, 2, 3, 5}) {
    const Rig rig{rig_of(size, size)};
    const GroundConfig config;
    const Street seen{Image<float>{size, size, 1.0f}, Image<float>{size, size, 2.0f}};
    check_equal(on_gpu(rig, config, seen, calibrated_ground(rig, config)),
                on_cpu(rig, config, seen, calibrated_ground(rig, config)));
  }
}

}  // namespace
}  // namespace stereogrid::test
