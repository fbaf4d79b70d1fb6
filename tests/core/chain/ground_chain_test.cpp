// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The ground of whole drives through scenes, whose road is flat and whose camera is where its rig says.
#include <gtest/gtest.h>

#include "ground_drive.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::test {
namespace {

using scenes::Scene;

constexpr const char* street{"street?width=400&height=250"};

struct Errors {
  double height{0};
  double pitch{0};
  double roll{0};
};

// Root mean square of the errors, each divided by its standard deviation.
Errors normalised_errors(const Rig& rig, const std::vector<Ground>& grounds) {
  Errors sum;
  for (const Ground& ground : grounds) {
    EXPECT_TRUE(ground.estimated);
    sum.height += std::pow((ground.height_m - rig.camera_height_m) / ground.height_sigma_m, 2);
    sum.pitch += std::pow((ground.pitch_rad - rig.camera_pitch_rad) / ground.pitch_sigma_rad, 2);
    sum.roll += std::pow((ground.roll_rad - rig.camera_roll_rad) / ground.roll_sigma_rad, 2);
  }
  const auto frames{static_cast<double>(grounds.size())};
  return {std::sqrt(sum.height / frames), std::sqrt(sum.pitch / frames), std::sqrt(sum.roll / frames)};
}

TEST(GroundChain, RecoversFromAWrongCalibration) {
  const Scene scene{scenes::parse_scene(street), 2};
  const std::vector<StereoFrame> frames{frames_of(scene, 7)};
  const std::vector<Ground> right{grounds_of(frames, scene.rig())};
  for (const WrongBy& by : {WrongBy{1, 0, 0}, WrongBy{-1, 0, 0}, WrongBy{2, 0, 0}, WrongBy{-2, 0, 0}, WrongBy{0, 1, 0},
                            WrongBy{0, -1, 0}, WrongBy{0, 0, 0.1}, WrongBy{0, 0, -0.1}, WrongBy{1, -1, 0.1}}) {
    SCOPED_TRACE(testing::Message() << by.pitch_deg << "° " << by.roll_deg << "° " << by.height_m << " m");
    expect_recovered(right, grounds_of(frames, wrong(scene.rig(), by)));
  }
}

TEST(GroundChain, FollowsAJumpOfThePitchAndBack) {
  const Scene scene{scenes::parse_scene(street), 2};
  const std::vector<StereoFrame> frames{frames_of(scene, 9)};
  for (const double pitch_deg : {1.0, -1.0, 2.0}) {
    const std::vector<Ground> grounds{grounds_of(frames, scene.rig(), {3, 6, pitch_deg * degree})};
    for (std::size_t i{0}; i < grounds.size(); ++i) {
      if (i == 3 || i == 6) continue;  // the filter may take a frame
      EXPECT_NEAR(grounds[i].pitch_rad / degree, i > 3 && i < 6 ? pitch_deg : 0, 0.3) << "frame " << i;
    }
  }
}

TEST(GroundChain, ErrorsAreAboutAsLargeAsItSays) {
  for (const char* text : {street, "crossing", "empty"}) {
    const Scene scene{scenes::parse_scene(text), 2};
    const Errors errors{normalised_errors(scene.rig(), grounds_of(frames_of(scene, 8), scene.rig()))};
    for (const double error : {errors.height, errors.pitch, errors.roll}) {
      EXPECT_GT(error, 0.1) << text;
      EXPECT_LT(error, 2) << text;
    }
  }
}

// A wall on the left, a pavement 12 cm up on the right, and between them little but the van.
TEST(GroundChain, HoldsBehindAVanThatHidesTheRoad) {
  const Scene scene{scenes::parse_scene("van"), 2};
  const std::vector<Ground> grounds{grounds_of(frames_of(scene, 30), scene.rig())};
  for (const Ground& ground : grounds) {
    EXPECT_NEAR(ground.height_m, scene.rig().camera_height_m, 0.03);
    EXPECT_NEAR(ground.pitch_rad / degree, 0, 0.4);
    EXPECT_NEAR(ground.roll_rad / degree, 0, 0.4);
  }
  const Errors errors{normalised_errors(scene.rig(), grounds)};
  EXPECT_LT(errors.pitch, 3);
  EXPECT_LT(errors.height, 3);
}

TEST(GroundChain, AWallOverEverythingIsNoRoad) {
  const Scene scene{scenes::parse_scene("wall"), 2};
  const std::vector<Ground> grounds{grounds_of(frames_of(scene, 5), scene.rig())};
  for (const Ground& ground : grounds) {
    EXPECT_TRUE(ground.estimated);
    EXPECT_NEAR(ground.height_m, scene.rig().camera_height_m, 0.03);
    EXPECT_NEAR(ground.pitch_rad / degree, 0, 0.3);
  }
}

}  // namespace
}  // namespace stereogrid::test
