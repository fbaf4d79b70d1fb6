// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/ground.hpp"

#include <gtest/gtest.h>

#include <algorithm>
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
  return config;
}

struct Street {
  Image<float> obstacle;
  Image<float> road;
};

constexpr double frame_s{0.1};

struct Flaws {
  double noise_px{0.3};
  double outliers{0.2};  // share of the pixels with any disparity
  bool van{false};       // hides most of the road ahead
  int tile_px{1};        // the noise is the same within squares of this size
};

// Matches of an ideal matcher on an endless road, with flaws.
Street street(const Rig& rig, const Ground& truth, const Flaws& flaws, unsigned seed) {
  std::mt19937 generator{seed};
  const RoadPlane plane{road_plane(rig, truth)};
  Street seen{Image<float>{rig.width_px, rig.height_px}, Image<float>{rig.width_px, rig.height_px}};
  Image<double> noise{rig.width_px / flaws.tile_px + 1, rig.height_px / flaws.tile_px + 1};
  for (double& n : noise) n = flaws.noise_px * gaussian(generator);
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double d{plane.disparity(u, v)};
      const bool on_van{flaws.van && u > 200 && u < 430 && v > 40 && d < 20};
      if (on_van) {
        seen.obstacle(u, v) = 20;
      } else if (d >= 1) {
        const bool outlier{uniform(generator, 0, 1) < flaws.outliers};
        seen.road(u, v) = static_cast<float>(outlier ? uniform(generator, 1, 60)
                                                     : std::max(d + noise(u / flaws.tile_px, v / flaws.tile_px), 0.5));
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
  return calibrated_ground(rig, gates());
}

// As sure as after some frames on a good road.
Ground tracked(const Ground& ground) {
  Ground sure{ground};
  sure.height_sigma_m = 0.005;
  sure.pitch_sigma_rad = sure.roll_sigma_rad = 0.05 * degree;
  return sure;
}

Ground carried_over(const Rig& rig, const GroundConfig& config, const Ground& before) {
  return predicted(rig, config, before, frame_s);
}

class EstimateGround : public ::testing::Test {
 protected:
  Rig rig{small_kitti_rig()};
  GroundSpace space{rig.width_px, rig.height_px};
};
using IsLost = EstimateGround;
using SearchGround = EstimateGround;

TEST_F(EstimateGround, RecoversHeightPitchAndRoll) {
  unsigned seed{1};
  for (const Ground& truth :
       {Ground{1.65, 0, 0, false}, Ground{1.70, 0.2 * degree, 0, false},
        Ground{1.60, -0.2 * degree, 0.8 * degree, false}, Ground{1.62, 0.15 * degree, -0.8 * degree, false}}) {
    const Street seen{street(rig, truth, {0.3, 0, false}, seed++)};
    const Ground found{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), frame_s, space)};
    EXPECT_TRUE(found.estimated);
    expect_close(found, truth, 0.01, 0.03);
  }
}

TEST_F(EstimateGround, BearsOutliersAndAVanThatHidesTheRoad) {
  const Ground truth{1.68, 0.2 * degree, -0.5 * degree, false};
  const Street seen{street(rig, truth, {0.3, 0.2, true}, 7)};
  const Ground found{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), frame_s, space)};
  EXPECT_TRUE(found.estimated);
  expect_close(found, truth, 0.02, 0.05);
}

TEST_F(EstimateGround, WithoutRoadKeepsThePlaneBeforeAndGrowsUncertain) {
  const Image<float> nothing{rig.width_px, rig.height_px};
  const Ground before{tracked({1.7, 0.01, -0.02, true})};
  Ground ground{before};
  for (int frame{0}; frame < 1000; ++frame) {
    const Ground next{estimate_ground(rig, gates(), nothing.view(), ground, frame_s, space)};
    EXPECT_FALSE(next.estimated);
    EXPECT_GE(next.pitch_sigma_rad, ground.pitch_sigma_rad);
    EXPECT_GE(next.height_sigma_m, ground.height_sigma_m);
    EXPECT_GE(next.roll_sigma_rad, ground.roll_sigma_rad);
    ground = next;
    if (frame == 9) {
      EXPECT_NEAR(ground.pitch_sigma_rad / degree, std::hypot(0.05, pitch_noise_rad / degree), 1e-9)
          << "after a second";
    }
  }
  EXPECT_EQ(ground.height_m, before.height_m);
  EXPECT_EQ(ground.pitch_rad, before.pitch_rad);
  EXPECT_EQ(ground.roll_rad, before.roll_rad);
  EXPECT_EQ(ground.pitch_sigma_rad, calibrated(rig).pitch_sigma_rad) << "no less certain than the calibration";
}

TEST_F(EstimateGround, AFewPixelsAreNoRoad) {
  Street seen{street(rig, {1.65, 0, 0, false}, {0, 0, false}, 3)};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) seen.road(u, v) = v < 150 && u > 300 && u < 320 ? seen.road(u, v) : 0.0f;
  }
  EXPECT_FALSE(estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), frame_s, space).estimated);
}

// The fit itself converges in each of these cases; only the gate says no. (A plane before that lies within it would
// hold the result there.)
TEST_F(EstimateGround, BeyondAGateThePlaneBeforeIsCarriedOver) {
  GroundConfig height{gates()};
  GroundConfig pitch{gates()};
  GroundConfig roll{gates()};
  height.height_gate_m = 0.03;
  pitch.pitch_gate_deg = 0.1;
  roll.roll_gate_deg = 0.2;
  const Ground truth{1.70, 0.2 * degree, 0.5 * degree, false};
  const Street seen{street(rig, truth, {0.2, 0, false}, 4)};
  const Ground before{tracked({1.69, 0.18 * degree, 0.45 * degree, true})};
  EXPECT_TRUE(estimate_ground(rig, gates(), seen.road.view(), before, frame_s, space).estimated);
  for (const GroundConfig& config : {height, pitch, roll}) {
    EXPECT_EQ(estimate_ground(rig, config, seen.road.view(), before, frame_s, space),
              carried_over(rig, config, before));
  }
}

TEST_F(EstimateGround, WeighsThePlaneBeforeByItsCertainty) {
  const Ground truth{1.70, 0.1 * degree, 0.4 * degree, false};
  const Street seen{street(rig, truth, {0.3, 0, false}, 4)};
  Ground before{calibrated(rig)};
  expect_close(estimate_ground(rig, gates(), seen.road.view(), before, frame_s, space), truth, 0.01, 0.03);
  before.height_sigma_m = 1e-4;
  before.pitch_sigma_rad = before.roll_sigma_rad = 1e-5;
  const Ground found{estimate_ground(rig, gates(), seen.road.view(), before, 1e-9, space)};
  EXPECT_TRUE(found.estimated);
  expect_close(found, before, 0.002, 0.005);
}

// Noise that neighbours have in common is what real disparities have.
TEST_F(EstimateGround, ErrorsAreAsLargeAsItSays) {
  constexpr int trials{60};
  double height{0};
  double pitch{0};
  double roll{0};
  double at_road{0};
  const Ground truth{1.68, 0.3 * degree, -0.4 * degree, false};
  for (unsigned seed{100}; seed < 100 + trials; ++seed) {
    const Street seen{street(rig, truth, {0.3, 0.1, true, 20}, seed)};
    const Ground found{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), frame_s, space)};
    ASSERT_TRUE(found.estimated);
    height += std::pow((found.height_m - truth.height_m) / found.height_sigma_m, 2);
    pitch += std::pow((found.pitch_rad - truth.pitch_rad) / found.pitch_sigma_rad, 2);
    roll += std::pow((found.roll_rad - truth.roll_rad) / found.roll_sigma_rad, 2);
    const double error_px{road_plane(rig, found).disparity(200, 150) - road_plane(rig, truth).disparity(200, 150)};
    at_road += std::pow(error_px / plane_sigma_px(rig, found, 200, 150), 2);
  }
  for (const double sum : {height, pitch, roll, at_road}) {
    EXPECT_GT(std::sqrt(sum / trials), 0.6);
    EXPECT_LT(std::sqrt(sum / trials), 1.5);
  }
}

TEST_F(EstimateGround, LessRoadIsLessCertain) {
  Street seen{street(rig, {1.65, 0, 0, false}, {0.3, 0, false, 20}, 3)};
  const Ground whole{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), frame_s, space)};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{150}; u < rig.width_px; ++u) seen.road(u, v) = 0;
  }
  const Ground strip{estimate_ground(rig, gates(), seen.road.view(), calibrated(rig), frame_s, space)};
  EXPECT_TRUE(strip.estimated);
  EXPECT_GT(strip.roll_sigma_rad, 2 * whole.roll_sigma_rad);
  EXPECT_GT(strip.pitch_sigma_rad, whole.pitch_sigma_rad);
}

// Matched as road, since the road hypothesis searches around the plane.
TEST_F(EstimateGround, APavementOnOneSideDoesNotTiltIt) {
  const Ground truth{1.65, 0.1 * degree, 0, false};
  Street seen{street(rig, truth, {0.1, 0, false, 10}, 5)};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double raised{seen.road(u, v) * truth.height_m / (truth.height_m - 0.12)};
      const double right_m{(u - rig.cx_px) * rig.baseline_m / raised};
      if (seen.road(u, v) > 0 && right_m > 1.7) seen.road(u, v) = static_cast<float>(raised);
    }
  }
  const Ground found{estimate_ground(rig, gates(), seen.road.view(), tracked(truth), frame_s, space)};
  expect_close(found, truth, 0.02, 0.3);  // through both: roll 1.6°
}

// Level to the right of a crease 1.5 m left of the axis; from there it falls off by 6°, over 3.5 m.
double cambered_road(const Rig& rig, double height_m, int u, int v) {
  const double x{(u - rig.cx_px) / rig.focal_px};
  const double y{(v - rig.cy_px) / rig.focal_px};
  double z{height_m / y};
  for (int step{0}; step < 30; ++step) {
    const double fallen_m{std::clamp(-1.5 - x * z, 0.0, 3.5) * std::tan(6 * degree)};
    z = (z + (height_m + fallen_m) / y) / 2;
  }
  return rig.focal_px * rig.baseline_m / z;
}

TEST_F(EstimateGround, OnACamberedRoadTheSamePlaneIsFoundFromEverywhere) {
  std::mt19937 generator{6};
  Image<float> road{rig.width_px, rig.height_px};
  for (int v{static_cast<int>(rig.cy_px) + 12}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u)
      road(u, v) = static_cast<float>(cambered_road(rig, 1.65, u, v) + 0.1 * gaussian(generator));
  }
  const auto found_from = [&](const Ground& start) {
    return estimate_ground(rig, gates(), road.view(), with_covariance(start, covariance_of(calibrated(rig))), frame_s,
                           space);
  };
  const Ground lane{found_from({1.65, 0, 0, false})};
  EXPECT_TRUE(lane.estimated);
  for (const Ground& start : {Ground{1.74, 0.35 * degree, 3.5 * degree, false}, Ground{1.65, 0, 3.5 * degree, false},
                              Ground{1.6, -0.2 * degree, -1 * degree, false}}) {
    SCOPED_TRACE(testing::Message() << start.height_m << " m, " << start.roll_rad / degree << "°");
    expect_close(found_from(start), lane, 0.03, 0.4);  // from the first of them, in its surroundings: 0.1 m, 2°
  }
}

TEST_F(EstimateGround, CanBeSwitchedOff) {
  GroundConfig config{gates()};
  config.estimate = false;
  const Street seen{street(rig, {1.70, 0.003, 0, false}, {0, 0, false}, 4)};
  const Ground before{1.65, 0, 0, true};
  EXPECT_EQ(estimate_ground(rig, config, seen.road.view(), before, frame_s, space), (Ground{1.65, 0, 0, false}));
  EXPECT_EQ(search_ground(rig, config, seen.obstacle.view(), seen.road.view(), before, space),
            (Ground{1.65, 0, 0, false}));
}

TEST_F(IsLost, WhenTheRoadLiesElsewhere) {
  const Ground truth{1.65, 0.2 * degree, 0.3 * degree, false};
  const Street seen{street(rig, truth, {0.3, 0.2, true}, 31)};
  const auto lost = [&](double pitch_deg) {
    const Ground ground{truth.height_m, truth.pitch_rad + pitch_deg * degree, truth.roll_rad, true};
    return is_lost(rig, gates(), seen.obstacle.view(), seen.road.view(), ground, space);
  };
  EXPECT_FALSE(lost(0));
  EXPECT_FALSE(lost(0.3)) << "the fit reaches that far";
  for (const double pitch_deg : {-2.0, 2.0, 3.0}) EXPECT_TRUE(lost(pitch_deg)) << pitch_deg;
  const Image<float> nothing{rig.width_px, rig.height_px};
  EXPECT_FALSE(is_lost(rig, gates(), nothing.view(), nothing.view(), truth, space));
}

TEST_F(SearchGround, FindsARoadWhoseCalibratedPitchIsADegreeWrong) {
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
TEST_F(SearchGround, FindsARoadFarFromTheCalibration) {
  rig.focal_px = 721;
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
TEST_F(SearchGround, ReadsTheObstaclesDisparitiesToo) {
  const Ground truth{1.60, 1 * degree, 0, false};
  const Street seen{street(rig, truth, {0.3, 0.2, false}, 12)};
  const Image<float> nothing{rig.width_px, rig.height_px};
  expect_close(search_ground(rig, gates(), seen.road.view(), nothing.view(), calibrated(rig), space), truth, 0.02,
               0.05);
}

TEST_F(SearchGround, FallsBackToTheCalibration) {
  const Image<float> nothing{rig.width_px, rig.height_px};
  const Ground fallback{calibrated(rig)};
  EXPECT_EQ(search_ground(rig, gates(), nothing.view(), nothing.view(), fallback, space), fallback);
  // a wall from side to side
  const Image<float> wall{rig.width_px, rig.height_px, 15.0f};
  EXPECT_EQ(search_ground(rig, gates(), wall.view(), nothing.view(), fallback, space), fallback);
}

TEST_F(SearchGround, GivesTheSameAnswerEveryTime) {
  const Street seen{street(rig, {1.7, 0.01, 0.005, false}, {0.3, 0.3, true}, 13)};
  const Ground once{search_ground(rig, gates(), seen.obstacle.view(), seen.road.view(), calibrated(rig), space)};
  EXPECT_EQ(search_ground(rig, gates(), seen.obstacle.view(), seen.road.view(), calibrated(rig), space), once);
}

}  // namespace
}  // namespace stereogrid::test
