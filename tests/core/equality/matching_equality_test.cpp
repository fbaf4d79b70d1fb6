// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "matching_equality.hpp"

namespace stereogrid::test {
namespace {

TEST(MatchingEquality, CpuEqualsReferenceOnTinyImages) {
  std::mt19937 generator{61};
  for (const Size size : {Size{1, 1}, Size{3, 2}, Size{7, 5}, Size{2, 9}}) {
    for (const int window_px : {3, 5, 13, 21}) {
      for (const int disparities : {2, 16, 64, 70}) {
        expect_equal_to_reference(noise_pair(size, generator), rolled_plane, config_of(window_px, disparities),
                                  {1, 2, 3, 8});
      }
    }
  }
}

TEST(MatchingEquality, CpuEqualsReferenceOnSmallImages) {
  std::mt19937 generator{67};
  for (const int window_px : {3, 5, 13, 21}) {
    for (const int disparities : {2, 16, 64}) {
      expect_equal_to_reference(noise_pair({33, 17}, generator), plain_plane, config_of(window_px, disparities), {2});
      expect_equal_to_reference(textured_pair({33, 17}, generator), rolled_plane, config_of(window_px, disparities),
                                {5});
    }
  }
}

TEST(MatchingEquality, CpuEqualsReferenceOnLargerImages) {
  std::mt19937 generator{71};
  expect_equal_to_reference(noise_pair({61, 40}, generator), rolled_plane, config_of(5, 70), {1, 2, 5});
  expect_equal_to_reference(textured_pair({61, 40}, generator), falling_plane, config_of(13, 16), {1, 2});
  expect_equal_to_reference(textured_pair({65, 31}, generator), plain_plane, config_of(13, 64), {2, 5});
  expect_equal_to_reference(noise_pair({65, 31}, generator), falling_plane, config_of(21, 16), {5});
  expect_equal_to_reference(textured_pair({65, 31}, generator), rolled_plane, config_of(3, 70), {1, 2, 5});
}

// Several vectors of shifts, and costs beyond 15 bits.
TEST(MatchingEquality, CpuEqualsReferenceOnManyDisparities) {
  std::mt19937 generator{73};
  expect_equal_to_reference(noise_pair({140, 9}, generator), plain_plane, config_of(5, 129), {2});
  expect_equal_to_reference(noise_pair({9, 5}, generator), plain_plane, config_of(41, 65), {2});
}

TEST(MatchingEquality, CpuEqualsReferenceWithEveryOption) {
  std::mt19937 generator{79};
  for (int option{0}; option < 6; ++option) {
    MatchingConfig config{config_of(7, 24)};
    config.subpixel = option != 0;
    if (option == 1) config.left_right_px = 0;
    if (option == 2) config.uniqueness = 0;
    if (option == 3) config.speckle_px = config.road_speckle_px = 0;
    if (option == 4) config.texture = 20;
    if (option == 5) config.cost_limit = 0.2;
    expect_equal_to_reference(textured_pair({49, 23}, generator), plain_plane, config, {2});
  }
}

TEST(MatchingEquality, BlankImages) {
  const Image<std::uint8_t> blank{40, 20, 128};
  expect_equal_to_reference({blank, blank}, plain_plane, config_of(5, 16), {2});
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
  expect_equal(expected, run);
}

}  // namespace
}  // namespace stereogrid::test
