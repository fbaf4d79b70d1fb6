// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

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
  for (int v{0}; v < frame.left.height(); ++v) {
    for (int u{0}; u < frame.left.width(); ++u) {
      if (truth.seen_by_both(u, v) == 0) continue;
      const double at{u - double{truth.disparity(u, v)} - error_px};
      const int k{static_cast<int>(std::floor(at))};
      if (k < 0 || k + 1 >= frame.right.width()) continue;
      const double right{frame.right(k, v) + (at - k) * (frame.right(k + 1, v) - frame.right(k, v))};
      difference.mean_absolute += std::abs(frame.left(u, v) - right / gain);
      ++difference.pixels;
    }
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

}  // namespace
}  // namespace stereogrid::scenes
