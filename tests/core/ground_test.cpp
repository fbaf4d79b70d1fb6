// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/ground.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support.hpp"

namespace stereogrid::test {
namespace {

GroundConfig gates() {
  GroundConfig config;
  config.estimate = true;
  config.height_gate_m = 0.25;
  config.pitch_gate_deg = 3;
  config.roll_gate_deg = 4;
  config.smoothing = 0.5;
  return config;
}

struct Street {
  Image<float> obstacle;
  Image<float> road;
};

struct Flaws {
  double noise_px{0.3};
  double outliers{0.2};  // share of the pixels with any disparity
  bool van{false};       // hides most of the road ahead
};

// What an ideal matcher makes of an endless road, with flaws.
Street street(const Rig& rig, const Ground& truth, const Flaws& flaws, unsigned seed) {
  std::mt19937 generator{seed};
  const RoadPlane plane{road_plane(rig, truth)};
  Street seen{Image<float>{rig.width_px, rig.height_px}, Image<float>{rig.width_px, rig.height_px}};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double d{plane.disparity(u, v)};
      const bool on_van{flaws.van && u > 200 && u < 430 && v > 40 && d < 20};
      if (on_van) {
        seen.obstacle(u, v) = 20;
      } else if (d >= 1) {
        const bool outlier{uniform(generator, 0, 1) < flaws.outliers};
        seen.road(u, v) = static_cast<float>(outlier ? uniform(generator, 1, 60)
                                                     : std::max(d + flaws.noise_px * gaussian(generator), 0.5));
      }
    }
  }
  return seen;
}

void expect_close(const Ground& found, const Ground& truth, double height_m, double angle_deg) {
  EXPECT_NEAR(found.height_m, truth.height_m, height_m);
  EXPECT_NEAR(found.pitch_rad / degree, truth.pitch_rad / degree, angle_deg);
  EXPECT_NEAR(found.roll_rad / degree, truth.roll_rad / degree, angle_deg);
}

Ground calibrated(const Rig& rig) {
  return {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad, false};
}

TEST(EstimateGround, RecoversHeightPitchAndRoll) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  unsigned seed{1};
  for (const Ground& truth :
       {Ground{1.65, 0, 0, false}, Ground{1.70, 0.2 * degree, 0, false},
        Ground{1.60, -0.2 * degree, 0.8 * degree, false}, Ground{1.62, 0.15 * degree, -0.8 * degree, false}}) {
    const Street seen{street(rig, truth, {0.3, 0, false}, seed++)};
    const Ground found{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), space)};
    EXPECT_TRUE(found.estimated);
    expect_close(found, truth, 0.01, 0.03);
  }
}

TEST(EstimateGround, BearsOutliersAndAVanThatHidesTheRoad) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  const Ground truth{1.68, 0.2 * degree, -0.5 * degree, false};
  const Street seen{street(rig, truth, {0.3, 0.2, true}, 7)};
  const Ground found{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), space)};
  EXPECT_TRUE(found.estimated);
  expect_close(found, truth, 0.02, 0.05);
}

TEST(EstimateGround, WithoutRoadKeepsThePlaneBefore) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  const Image<float> nothing{rig.width_px, rig.height_px};
  const Ground before{1.7, 0.01, -0.02, true};
  const Ground found{estimate_ground(rig, gates(), nothing.view(), before, space)};
  EXPECT_EQ(found, (Ground{1.7, 0.01, -0.02, false}));
}

TEST(EstimateGround, AFewPixelsAreNoRoad) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  Street seen{street(rig, {1.65, 0, 0, false}, {0, 0, false}, 3)};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) seen.road(u, v) = v < 150 && u > 300 && u < 320 ? seen.road(u, v) : 0.0f;
  }
  EXPECT_FALSE(estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), space).estimated);
}

// The fit itself converges in each of these cases; only the gate says no.
TEST(EstimateGround, BeyondAGateThePlaneBeforeIsCarriedOver) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  GroundConfig height{gates()};
  GroundConfig pitch{gates()};
  GroundConfig roll{gates()};
  height.height_gate_m = 0.03;
  pitch.pitch_gate_deg = 0.1;
  roll.roll_gate_deg = 0.2;
  const Ground truth{1.70, 0.2 * degree, 0.5 * degree, false};
  const Street seen{street(rig, truth, {0.2, 0, false}, 4)};
  const Ground before{1.66, 0.001, 0.002, true};
  EXPECT_TRUE(estimate_ground(rig, gates(), seen.road.view(), before, space).estimated);
  for (const GroundConfig& config : {height, pitch, roll}) {
    EXPECT_EQ(estimate_ground(rig, config, seen.road.view(), before, space), (Ground{1.66, 0.001, 0.002, false}));
  }
}

TEST(EstimateGround, SmoothsWithTheFrameBeforeOnlyIfThatWasMeasured) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  GroundConfig config{gates()};
  config.smoothing = 0.75;
  const Ground truth{1.70, 0.1 * degree, 0.4 * degree, false};
  const Street seen{street(rig, truth, {0, 0, false}, 4)};
  Ground before{1.66, 0, 0, true};
  // three parts of the frame before, one part of this one
  expect_close(estimate_ground(rig, config, seen.road.view(), before, space),
               {1.67, 0.025 * degree, 0.1 * degree, false}, 0.002, 0.01);
  before.estimated = false;
  expect_close(estimate_ground(rig, config, seen.road.view(), before, space), truth, 0.003, 0.01);
}

TEST(EstimateGround, CanBeSwitchedOff) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  GroundConfig config{gates()};
  config.estimate = false;
  const Street seen{street(rig, {1.70, 0.003, 0, false}, {0, 0, false}, 4)};
  const Ground before{1.65, 0, 0, true};
  EXPECT_EQ(estimate_ground(rig, config, seen.road.view(), before, space), (Ground{1.65, 0, 0, false}));
  EXPECT_EQ(search_ground(rig, config, seen.obstacle.view(), seen.road.view(), before, space),
            (Ground{1.65, 0, 0, false}));
}

TEST(SearchGround, FindsARoadWhoseCalibratedPitchIsADegreeWrong) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  unsigned seed{11};
  for (const double pitch_deg : {1.0, -1.0, 2.0}) {
    const Ground truth{1.60, pitch_deg * degree, 0.5 * degree, false};
    const Street seen{street(rig, truth, {0.3, 0.2, true}, seed++)};
    const Ground found{search_ground(rig, gates(), seen.obstacle.view(), seen.road.view(), calibrated(rig), space)};
    EXPECT_TRUE(found.estimated);
    expect_close(found, truth, 0.03, 0.06);
  }
}

// With a long lens two degrees are 8 px of disparity, out of the reach of a fit that starts at the calibration.
TEST(SearchGround, FindsARoadFarFromTheCalibration) {
  Rig rig{small_kitti_rig()};
  rig.focal_px = 721;
  GroundSpace space{rig.width_px, rig.height_px};
  unsigned seed{21};
  for (const double pitch_deg : {2.0, -1.5}) {
    const Ground truth{1.50, pitch_deg * degree, -0.5 * degree, false};
    const Street seen{street(rig, truth, {0.3, 0.2, false}, seed++)};
    const Ground found{search_ground(rig, gates(), seen.obstacle.view(), seen.road.view(), calibrated(rig), space)};
    EXPECT_TRUE(found.estimated);
    expect_close(found, truth, 0.03, 0.06);
  }
}

// At the start the road has often been taken for upright surfaces.
TEST(SearchGround, ReadsTheObstaclesDisparitiesToo) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  const Ground truth{1.60, 1 * degree, 0, false};
  const Street seen{street(rig, truth, {0.3, 0.2, false}, 12)};
  const Image<float> nothing{rig.width_px, rig.height_px};
  expect_close(search_ground(rig, gates(), seen.road.view(), nothing.view(), calibrated(rig), space), truth, 0.02,
               0.05);
}

TEST(SearchGround, FallsBackToTheCalibration) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  const Image<float> nothing{rig.width_px, rig.height_px};
  const Ground fallback{calibrated(rig)};
  EXPECT_EQ(search_ground(rig, gates(), nothing.view(), nothing.view(), fallback, space), fallback);
  // a wall from side to side
  const Image<float> wall{rig.width_px, rig.height_px, 15.0f};
  EXPECT_EQ(search_ground(rig, gates(), wall.view(), nothing.view(), fallback, space), fallback);
}

TEST(SearchGround, GivesTheSameAnswerEveryTime) {
  const Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
  const Street seen{street(rig, {1.7, 0.01, 0.005, false}, {0.3, 0.3, true}, 13)};
  const Ground once{search_ground(rig, gates(), seen.obstacle.view(), seen.road.view(), calibrated(rig), space)};
  EXPECT_EQ(search_ground(rig, gates(), seen.obstacle.view(), seen.road.view(), calibrated(rig), space), once);
}

}  // namespace
}  // namespace stereogrid::test
