// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "matching_run.hpp"
#include "stereogrid/pipeline.hpp"
#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {

struct Size {
  int width;
  int height;
};

struct Pair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

inline Pair noise_pair(Size size, std::mt19937& generator) {
  return {noise_image(size.width, size.height, generator), noise_image(size.width, size.height, generator)};
}

/// Texture with a step in disparity, and a flat patch where many costs tie.
inline Pair textured_pair(Size size, std::mt19937& generator) {
  const Texture texture{static_cast<unsigned>(generator())};
  const auto shift = [&](int u) { return u < size.width / 2 ? 3 : 8; };
  Pair pair{textured_image(texture, size.width, size.height, [](int u, int) { return u; }),
            textured_image(texture, size.width, size.height, [&](int u, int) { return u + shift(u); })};
  for (int v{size.height / 2}; v < size.height; ++v) {
    for (int u{0}; u < size.width / 3; ++u) pair.left(u, v) = pair.right(u, v) = 90;
  }
  return pair;
}

/// Settings where every test of a match rejects some.
inline MatchingConfig config_of(int window_px, int disparities) {
  MatchingConfig config{permissive_config()};
  config.window_px = window_px;
  config.disparities = disparities;
  config.texture = 3;
  config.uniqueness = 0.05;
  config.speckle_px = config.road_speckle_px = 4;
  return config;
}

constexpr RoadPlane plain_plane{4, 0, 0.2, 20, 15};
constexpr RoadPlane rolled_plane{3.3, 0.07, 0.31, 30, 10};
constexpr RoadPlane falling_plane{-2, -0.11, 0.15, 10, 5};  // mostly behind the camera: negative disparities

inline int differences(const Image<Candidate>& a, const Image<Candidate>& b) {
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += a.data()[i] == b.data()[i] ? 0 : 1;
  return different;
}

inline void expect_equal(const MatchRun& expected, const MatchRun& actual) {
  EXPECT_EQ(differences(expected.upright, actual.upright), 0);
  EXPECT_EQ(differences(expected.level, actual.level), 0);
  EXPECT_EQ(count_differences(expected.matches.obstacle, actual.matches.obstacle), 0);
  for (std::size_t i{0}; i < expected.matches.obstacle.size(); ++i) {
    ASSERT_EQ(is_ambiguous(expected.matches.obstacle.data()[i]), is_ambiguous(actual.matches.obstacle.data()[i])) << i;
  }
  EXPECT_EQ(count_differences(expected.matches.road, actual.matches.road), 0);
  EXPECT_EQ(count_differences(expected.matches.confidence, actual.matches.confidence), 0);
}

/// The CPU's results are the reference's, on every instruction set of this machine and on each of these numbers of
/// threads.
inline void expect_equal_to_reference(const Pair& pair, const RoadPlane& plane, const MatchingConfig& config,
                                      const std::vector<int>& thread_counts) {
  Reference reference;
  const MatchRun expected{reference, pair.left, pair.right, plane, config};
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    ASSERT_EQ(simd_target(), name_of_target(target));
    for (const int threads : thread_counts) {
      SCOPED_TRACE(testing::Message() << pair.left.width() << " × " << pair.left.height() << ", window "
                                      << config.window_px << ", disparities " << config.disparities << ", "
                                      << simd_target() << ", " << threads << " threads");
      Cpu cpu{threads};
      expect_equal(expected, MatchRun{cpu, pair.left, pair.right, plane, config});
    }
  }
}

}  // namespace stereogrid::test
