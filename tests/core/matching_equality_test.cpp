// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "matching_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

struct Size {
  int width;
  int height;
};

int differences(const Image<Candidate>& a, const Image<Candidate>& b) {
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += a.data()[i] == b.data()[i] ? 0 : 1;
  return different;
}

struct Pair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

Pair noise_pair(Size size, std::mt19937& generator) {
  return {noise_image(size.width, size.height, generator), noise_image(size.width, size.height, generator)};
}

// Texture with a step in disparity, and a flat patch where many costs tie.
Pair textured_pair(Size size, std::mt19937& generator) {
  const Texture texture{static_cast<unsigned>(generator())};
  const auto shift = [&](int u) { return u < size.width / 2 ? 3 : 8; };
  Pair pair{textured_image(texture, size.width, size.height, [](int u, int) { return u; }),
            textured_image(texture, size.width, size.height, [&](int u, int) { return u + shift(u); })};
  for (int v{size.height / 2}; v < size.height; ++v) {
    for (int u{0}; u < size.width / 3; ++u) pair.left(u, v) = pair.right(u, v) = 90;
  }
  return pair;
}

void expect_equal(const Pair& pair, const RoadPlane& plane, const MatchingConfig& config,
                  const std::vector<int>& thread_counts) {
  Reference reference;
  const MatchRun slow{reference, pair.left, pair.right, plane, config};
  for (const int threads : thread_counts) {
    Cpu cpu{threads};
    const MatchRun fast{cpu, pair.left, pair.right, plane, config};
    const auto where = testing::Message()
                       << pair.left.width() << " × " << pair.left.height() << ", window " << config.window_px
                       << ", disparities " << config.disparities << ", " << threads << " threads";
    EXPECT_EQ(differences(slow.upright, fast.upright), 0) << where;
    EXPECT_EQ(differences(slow.level, fast.level), 0) << where;
    EXPECT_EQ(count_differences(slow.matches.obstacle, fast.matches.obstacle), 0) << where;
    EXPECT_EQ(count_differences(slow.matches.road, fast.matches.road), 0) << where;
    EXPECT_EQ(count_differences(slow.matches.confidence, fast.matches.confidence), 0) << where;
  }
}

MatchingConfig config_of(int window_px, int disparities) {
  MatchingConfig config{permissive_config()};
  config.window_px = window_px;
  config.disparities = disparities;
  config.road_margin_px = 1 + window_px % 4;
  config.texture = 3;
  config.uniqueness = 0.05;
  config.speckle_px = 4;
  return config;
}

const RoadPlane plain_plane{4, 0, 0.2, 20, 15};
const RoadPlane rolled_plane{3.3, 0.07, 0.31, 30, 10};
const RoadPlane falling_plane{-2, -0.11, 0.15, 10, 5};  // mostly behind the camera: negative disparities

TEST(MatchingEquality, CpuEqualsReferenceOnTinyImages) {
  std::mt19937 generator{61};
  for (const Size size : {Size{1, 1}, Size{3, 2}, Size{7, 5}, Size{2, 9}}) {
    for (const int window_px : {3, 5, 13, 21}) {
      for (const int disparities : {2, 16, 64, 70}) {
        expect_equal(noise_pair(size, generator), rolled_plane, config_of(window_px, disparities), {1, 5});
      }
    }
  }
}

TEST(MatchingEquality, CpuEqualsReferenceOnSmallImages) {
  std::mt19937 generator{67};
  for (const int window_px : {3, 5, 13, 21}) {
    for (const int disparities : {2, 16, 64}) {
      expect_equal(noise_pair({33, 17}, generator), plain_plane, config_of(window_px, disparities), {2});
      expect_equal(textured_pair({33, 17}, generator), rolled_plane, config_of(window_px, disparities), {5});
    }
  }
}

TEST(MatchingEquality, CpuEqualsReferenceOnLargerImages) {
  std::mt19937 generator{71};
  expect_equal(noise_pair({61, 40}, generator), rolled_plane, config_of(5, 70), {1, 2, 5});
  expect_equal(textured_pair({61, 40}, generator), falling_plane, config_of(13, 16), {1, 2});
  expect_equal(textured_pair({65, 31}, generator), plain_plane, config_of(13, 64), {2, 5});
  expect_equal(noise_pair({65, 31}, generator), falling_plane, config_of(21, 16), {5});
  expect_equal(textured_pair({65, 31}, generator), rolled_plane, config_of(3, 70), {1, 2, 5});
}

// Several vectors of shifts, and costs beyond 15 bits.
TEST(MatchingEquality, CpuEqualsReferenceOnManyDisparities) {
  std::mt19937 generator{73};
  expect_equal(noise_pair({140, 9}, generator), plain_plane, config_of(5, 129), {2});
  expect_equal(noise_pair({9, 5}, generator), plain_plane, config_of(41, 65), {2});
}

TEST(MatchingEquality, CpuEqualsReferenceWithEveryOption) {
  std::mt19937 generator{79};
  for (int option{0}; option < 5; ++option) {
    MatchingConfig config{config_of(7, 24)};
    config.subpixel = option != 0;
    if (option == 1) config.left_right_px = 0;
    if (option == 2) config.uniqueness = 0;
    if (option == 3) config.speckle_px = 0;
    if (option == 4) config.texture = 20;
    expect_equal(textured_pair({49, 23}, generator), plain_plane, config, {2});
  }
}

TEST(MatchingEquality, BlankImages) {
  const Image<std::uint8_t> blank{40, 20, 128};
  expect_equal({blank, blank}, plain_plane, config_of(5, 16), {2});
}

// One buffer serves images after one another.
TEST(MatchingEquality, WorkingMemoryIsUsedAgain) {
  std::mt19937 generator{83};
  Cpu cpu{2};
  const Pair first{noise_pair({61, 40}, generator)};
  const Pair second{textured_pair({61, 40}, generator)};
  const MatchingConfig config{config_of(9, 33)};
  MatchRun run{cpu, first.left, first.right, rolled_plane, config};
  run.run(cpu, second.left, second.right, rolled_plane, config);
  Reference reference;
  const MatchRun expected{reference, second.left, second.right, rolled_plane, config};
  EXPECT_EQ(differences(run.upright, expected.upright), 0);
  EXPECT_EQ(count_differences(run.matches.obstacle, expected.matches.obstacle), 0);
  EXPECT_EQ(count_differences(run.matches.road, expected.matches.road), 0);
}

}  // namespace
}  // namespace stereogrid::test
