// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "stereogrid/error.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::scenes {
namespace {

std::string error_text(const std::string& text) {
  try {
    static_cast<void>(Scene{parse_scene(text)});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseScene, ReadsEveryKey) {
  const SceneOptions options{
      parse_scene("scene:street?frames=12&seed=18446744073709551615&width=1242&height=375&focal=700.5&baseline=0.5&"
                  "camera_height=1.5&pitch_deg=3&roll_deg=-90&rate=20&noise=0&gain=0.9")};
  EXPECT_EQ(options.name, "street");
  EXPECT_EQ(options.frames, 12);
  EXPECT_EQ(options.seed, 18446744073709551615U);
  EXPECT_EQ(options.width_px, 1242);
  EXPECT_EQ(options.height_px, 375);
  EXPECT_EQ(options.focal_px, 700.5);
  EXPECT_EQ(options.baseline_m, 0.5);
  EXPECT_EQ(options.camera_height_m, 1.5);
  EXPECT_NEAR(options.camera_pitch_rad, 0.05235987755982989, 1e-15);
  EXPECT_NEAR(options.camera_roll_rad, -1.5707963267948966, 1e-15);
  EXPECT_EQ(options.rate_hz, 20);
  EXPECT_EQ(options.noise_grey, 0);
  EXPECT_EQ(options.gain, 0.9);
}

TEST(ParseScene, ReadsTheKeysOfUnevenGround) {
  const SceneOptions options{
      parse_scene("scene:terrain?kind=ditch&depth=0.8&at=6&span=1.5&slope_deg=-4&steps=3&skew_deg=20&speed=0&"
                  "camera=robot&pitch_noise_deg=1&roll_noise_deg=0.5&height_noise=0.01")};
  EXPECT_EQ(options.kind, "ditch");
  EXPECT_EQ(options.rise_m, -0.8);
  EXPECT_EQ(options.edge_m, 6);
  EXPECT_EQ(options.span_m, 1.5);
  EXPECT_EQ(options.slope_deg, -4);
  EXPECT_EQ(options.steps, 3);
  EXPECT_EQ(options.skew_deg, 20);
  EXPECT_EQ(options.speed_mps, 0);
  EXPECT_NEAR(options.pitch_noise_rad, 0.017453292519943295, 1e-12);
  EXPECT_NEAR(options.roll_noise_rad, 0.5 * 0.017453292519943295, 1e-12);
  EXPECT_EQ(options.height_noise_m, 0.01);
  const Scene robot{options};
  EXPECT_NEAR(robot.rig().camera_pitch_rad, 0.13962634015954636, 1e-12);
  EXPECT_EQ(robot.rig().baseline_m, 0.09);
  EXPECT_EQ(robot.rig().camera_height_m, 0.35);
  EXPECT_EQ(robot.truth_grid().geometry.cell_size_m, 0.05);
  EXPECT_EQ(parse_scene("terrain?camera=robot&pitch_deg=0").camera_pitch_rad, 0);
  EXPECT_NE(error_text("terrain?kind=ocean").find("Known kinds: random bank barrier"), std::string::npos);
  EXPECT_NE(error_text("terrain?camera=phone").find("Known cameras: car robot"), std::string::npos);
}

TEST(ParseScene, PrefixAndSettingsMayBeLeftOut) {
  EXPECT_EQ(parse_scene("empty").name, "empty");
  EXPECT_EQ(parse_scene("scene:empty?").name, "empty");
  EXPECT_EQ(parse_scene("wall?seed=4").seed, 4U);
}

TEST(ParseScene, ErrorsNameWhatWouldMend) {
  EXPECT_NE(error_text("scene:stret")
                .find("scene:stret: there is no such scene. Known scenes: boxes corridor course crossing empty"),
            std::string::npos);
  EXPECT_NE(error_text("").find("Known scenes"), std::string::npos);
  EXPECT_NE(error_text("street?widht=3").find("no key \"widht\". Known keys: seed, frames, width"), std::string::npos);
  EXPECT_NE(error_text("street?frames").find("key=value"), std::string::npos);
  EXPECT_NE(error_text("street?frames=0").find("frames is a whole number from 1 to 1000000"), std::string::npos);
  EXPECT_NE(error_text("street?frames=1.5").find("whole number"), std::string::npos);
  EXPECT_NE(error_text("street?frames=").find("cannot use frames=."), std::string::npos);
  EXPECT_NE(error_text("street?frames=3x").find("cannot use frames=3x."), std::string::npos);
  EXPECT_NE(error_text("street?seed=-1").find("seed is a whole number"), std::string::npos);
  EXPECT_NE(error_text("street?baseline=-0.2").find("baseline is a number from 0.01 to 5"), std::string::npos);
  EXPECT_NE(error_text("street?gain=nan").find("gain is a number"), std::string::npos);
  EXPECT_NE(error_text("street?&seed=1").find("cannot read \"\""), std::string::npos);
}

TEST(Scene, ChecksOptionsFromCodeToo) {
  SceneOptions options;
  options.name = "empty";
  options.rate_hz = 0;
  EXPECT_THROW(Scene{options}, InputError);
  options.rate_hz = 10;
  options.name = "nowhere";
  EXPECT_THROW(Scene{options}, InputError);
}

TEST(Scene, DefaultsFollowTheWidth) {
  const Scene narrow{parse_scene("street")};
  EXPECT_EQ(narrow.size(), 60U);
  EXPECT_EQ(narrow.rig(), (Rig{512, 320, 410, 256, 160, 0.22, 1.25, 0, 0}));
  const Scene wide{parse_scene("street?width=1242&height=375&frames=3")};
  EXPECT_EQ(wide.size(), 3U);
  EXPECT_EQ(wide.rig(), (Rig{1242, 375, 721.5, 621, 187.5, 0.54, 1.65, 0, 0}));
}

TEST(Scene, FramesHaveNamesStampsAndAnEnd) {
  const Scene scene{parse_scene("empty?width=32&height=20&frames=3&rate=20"), 1};
  EXPECT_EQ(scene.name(2), "000002");
  const StereoFrame frame{scene.load(2)};
  EXPECT_EQ(frame.name, "000002");
  EXPECT_EQ(frame.index, 2);
  EXPECT_EQ(frame.stamp_ns, 100000000);
  EXPECT_EQ(frame.left.width(), 32);
  EXPECT_EQ(frame.right.height(), 20);
  ASSERT_TRUE(frame.world_from_vehicle.has_value());
  EXPECT_NEAR(frame.world_from_vehicle->x_m, 0.5, 1e-12);
  EXPECT_THROW(static_cast<void>(scene.load(3)), InputError);
  EXPECT_THROW(static_cast<void>(scene.truth(3)), InputError);
}

TEST(Scene, EveryNameIsAScene) {
  EXPECT_GE(scene_names().size(), 5U);
  for (const std::string& name : scene_names()) {
    const Scene scene{parse_scene(name + "?width=64&height=41")};
    EXPECT_GT(scene.size(), 0U);
    EXPECT_EQ(scene.load(scene.size() - 1).left.height(), 41);
  }
}

}  // namespace
}  // namespace stereogrid::scenes
