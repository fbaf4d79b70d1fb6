// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "stereogrid/error.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::scenes {
namespace {

template <class T>
void add_to_hash(std::uint64_t& hash, T value) {
  for (std::size_t byte{0}; byte < sizeof value; ++byte) {
    hash = (hash ^ ((static_cast<std::uint64_t>(value) >> (8 * byte)) & 0xff)) * 0x100000001b3U;
  }
}

/// FNV-1a of the images, and of the disparities as they are stored (in 1/256 px), labels and cells.
std::uint64_t hash_of(const Scene& scene, std::size_t index) {
  std::uint64_t hash{0xcbf29ce484222325U};
  const StereoFrame frame{scene.load(index)};
  const FrameTruth truth{scene.truth(index)};
  for (const std::uint8_t grey : frame.left) add_to_hash(hash, grey);
  for (const std::uint8_t grey : frame.right) add_to_hash(hash, grey);
  for (const float d : truth.disparity) add_to_hash(hash, static_cast<std::uint16_t>(std::lround(256.0 * d)));
  for (const std::uint8_t label : truth.label) add_to_hash(hash, label);
  for (const std::uint8_t seen : truth.seen_by_both) add_to_hash(hash, seen);
  for (const std::uint8_t state : truth.state) add_to_hash(hash, state);
  return hash;
}

TEST(Pictures, ShowTheInstantFromElsewhere) {
  const Scene scene{parse_scene("corridor?camera=robot&width=160&height=100")};
  const auto is_same = [](const StereoFrame& a, const StereoFrame& b) { return std::ranges::equal(a.left, b.left); };
  const StereoFrame driven{scene.load(5)};
  const Pose2 place{*driven.world_from_vehicle};
  EXPECT_TRUE(is_same(scene.load(5, place), driven));
  const Pose2 elsewhere{place * Pose2{0.5, 0, 0.1}};
  const StereoFrame moved{scene.load(5, elsewhere)};
  EXPECT_EQ(moved.world_from_vehicle, elsewhere);
  EXPECT_EQ(moved.stamp_ns, driven.stamp_ns);
  EXPECT_FALSE(is_same(moved, driven));
}

TEST(Pictures, AreWhatTheyWere) {
  // A change of scene, texture or noise shows here. Where it is meant, write the new number.
  EXPECT_EQ(hash_of(Scene{parse_scene("street?width=160&height=100")}, 13), 375457141438053921U);
  EXPECT_EQ(hash_of(Scene{parse_scene("crossing?width=160&height=100&pitch_deg=2")}, 9), 17609103212911083558U);
}

TEST(Pictures, DependOnTheSeedNotOnThreads) {
  const Scene one{parse_scene("street?width=128&height=80&seed=5"), 1};
  const Scene two{parse_scene("street?width=128&height=80&seed=5"), 2};
  const Scene other{parse_scene("street?width=128&height=80&seed=6"), 1};
  EXPECT_EQ(hash_of(one, 7), hash_of(two, 7));
  EXPECT_EQ(hash_of(one, 7), hash_of(one, 7));
  EXPECT_FALSE(one.load(7).left == other.load(7).left);
}

TEST(Pictures, BeginAlikeHoweverManyFrames) {
  const Scene few{parse_scene("street?width=128&height=80&frames=4"), 1};
  const Scene usual{parse_scene("street?width=128&height=80"), 1};
  EXPECT_EQ(hash_of(few, 3), hash_of(usual, 3));
}

struct Difference {
  double mean_absolute{0};
  int pixels{0};
};

/// Left image against the right one warped by the true disparity plus an error.
Difference warped(const StereoFrame& frame, const FrameTruth& truth, double gain, double error_px) {
  Difference difference;
  for (const auto [u, v] : raster(frame.left)) {
    if (truth.seen_by_both(u, v) == 0) continue;
    const double at{u - double{truth.disparity(u, v)} - error_px};
    const int k{static_cast<int>(std::floor(at))};
    if (k < 0 || k + 1 >= frame.right.width()) continue;
    const double right{frame.right(k, v) + (at - k) * (frame.right(k + 1, v) - frame.right(k, v))};
    difference.mean_absolute += std::abs(frame.left(u, v) - right / gain);
    ++difference.pixels;
  }
  difference.mean_absolute /= difference.pixels;
  return difference;
}

class WarpTest : public testing::TestWithParam<const char*> {};

TEST_P(WarpTest, TheRightPictureMovedByTheTruthIsTheLeftOne) {
  const Scene scene{parse_scene(std::string{GetParam()} + "&noise=0&gain=1")};
  const StereoFrame frame{scene.load(5)};
  const FrameTruth truth{scene.truth(5)};
  const Difference exact{warped(frame, truth, 1, 0)};
  EXPECT_GT(exact.pixels, 60000);
  EXPECT_LT(exact.mean_absolute, 1.6);
  EXPECT_GT(warped(frame, truth, 1, 1).mean_absolute, 2 * exact.mean_absolute);
  EXPECT_GT(warped(frame, truth, 1, -1).mean_absolute, 2 * exact.mean_absolute);
}

INSTANTIATE_TEST_SUITE_P(Scenes, WarpTest,
                         testing::Values("street?seed=1", "street?pitch_deg=3", "crossing?seed=2", "occlusion?seed=3"));

TEST(Pictures, NoiseAndGainAreAsAskedFor) {
  const StereoFrame clean{Scene{parse_scene("crossing?noise=0&gain=1")}.load(0)};
  const StereoFrame noisy{Scene{parse_scene("crossing?noise=3&gain=1.1")}.load(0)};
  double left_squares{0};
  double right_sum{0};
  double clean_sum{0};
  double product{0};
  for (std::size_t i{0}; i < clean.left.size(); ++i) {
    const double left_noise{double(noisy.left.data()[i]) - clean.left.data()[i]};
    const double right_noise{double(noisy.right.data()[i]) - 1.1 * clean.right.data()[i]};
    left_squares += left_noise * left_noise;
    product += left_noise * right_noise;
    right_sum += noisy.right.data()[i];
    clean_sum += clean.right.data()[i];
  }
  const auto count = static_cast<double>(clean.left.size());
  EXPECT_NEAR(std::sqrt(left_squares / count), 3, 0.1);
  EXPECT_NEAR(right_sum / clean_sum, 1.1, 0.01);
  EXPECT_NEAR(product / count, 0, 0.15);  // each camera has its own
}

TEST(Pictures, AStillSceneChangesByNoiseAlone) {
  const Scene noisy{parse_scene("occlusion?width=128&height=80")};
  EXPECT_FALSE(noisy.load(0).left == noisy.load(1).left);
  const Scene clean{parse_scene("occlusion?width=128&height=80&noise=0")};
  EXPECT_TRUE(clean.load(0).left == clean.load(1).left);
  EXPECT_TRUE(clean.truth(0).disparity == clean.truth(1).disparity);
}

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
  for (const auto& [scene, words] : std::vector<std::pair<std::string, std::string>>{
           {"scene:stret", "scene:stret: there is no such scene. Known scenes: around boxes corridor course crossing"},
           {"", "Known scenes"},
           {"street?widht=3", "no key \"widht\". Known keys: seed, frames, width"},
           {"street?frames", "key=value"},
           {"street?frames=0", "frames is a whole number from 1 to 1000000"},
           {"street?frames=1.5", "whole number"},
           {"street?frames=", "cannot use frames=."},
           {"street?frames=3x", "cannot use frames=3x."},
           {"street?seed=-1", "seed is a whole number"},
           {"street?baseline=-0.2", "baseline is a number from 0.01 to 5"},
           {"street?gain=nan", "gain is a number"},
           {"street?&seed=1", "cannot read \"\""}}) {
    EXPECT_THAT(error_text(scene), testing::HasSubstr(words)) << scene;
  }
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
