// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "matching_run.hpp"

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

// Sizes and settings at the edges of what vectors hold, on every instruction set of this machine.

TEST(MatchingTargets, UsesTheSelectedTarget) {
  const auto targets = vector_targets();
  ASSERT_FALSE(targets.empty());
  EXPECT_EQ(simd_target(), name_of_target(targets.front())) << "the best is taken";
  for (const std::int64_t target : targets) {
    const ForcedTarget forced{target};
    EXPECT_EQ(simd_target(), name_of_target(target));
    std::cout << "tested: " << simd_target() << "\n";
  }
  EXPECT_EQ(simd_target(), name_of_target(targets.front())) << "as before";
}

TEST(MatchingTargets, WorksWithoutVectors) {
  std::mt19937 generator{101};
  const ForcedTarget forced{HWY_SCALAR};
  if (simd_target() != "SCALAR") GTEST_SKIP() << "Highway has vectors everywhere here: " << simd_target();
  const MatchingConfig config{config_of(5, 16)};
  const Pair pair{textured_pair({33, 17}, generator)};
  Reference reference;
  const MatchRun expected{reference, pair.left, pair.right, plain_plane, config};
  for (const int threads : {1, 3}) {
    Cpu cpu{threads};
    const MatchRun actual{cpu, pair.left, pair.right, plain_plane, config};
    expect_equal(expected, actual);
    const Image<float>& found{actual.matches.obstacle};
    EXPECT_GT(std::count_if(found.begin(), found.end(), [](float d) { return d > 0; }), 0);
  }
}

TEST(MatchingTargets, EveryNumberOfDisparitiesAtTheEndOfAVector) {
  std::mt19937 generator{103};
  for (const int power : {2, 4, 8, 16, 32, 64, 128, 256}) {
    for (const int disparities : {power - 1, power, power + 1}) {
      if (disparities > 256) continue;
      const MatchingConfig config{config_of(3, disparities)};
      expect_equal_to_reference(noise_pair({disparities + 6, 3}, generator), plain_plane, config, {1, 3});
      expect_equal_to_reference(noise_pair({19, 3}, generator), rolled_plane, config, {2});
    }
  }
}

TEST(MatchingTargets, EveryWidthAtTheEndOfAVector) {
  std::mt19937 generator{107};
  for (const int power : {2, 4, 8, 16, 32, 64, 128}) {
    for (const int width : {power - 1, power, power + 1}) {
      expect_equal_to_reference(noise_pair({width, 4}, generator), plain_plane, config_of(5, 20), {3});
    }
  }
}

TEST(MatchingTargets, EveryWindow) {
  std::mt19937 generator{109};
  for (int window_px{3}; window_px <= 41; window_px += 2) {
    expect_equal_to_reference(noise_pair({23, 5}, generator), rolled_plane, config_of(window_px, 9), {1, 8});
  }
}

// Everything differs, so the sums are the largest there are.
Pair opposed_pair(Size size) {
  Pair pair{Image<std::uint8_t>{size.width, size.height}, Image<std::uint8_t>{size.width, size.height}};
  for (const auto [u, v] : raster(size.width, size.height)) {
    pair.left(u, v) = static_cast<std::uint8_t>(5 * u + 7 * v);
    pair.right(u, v) = static_cast<std::uint8_t>(255 - 5 * u - 7 * v);
  }
  return pair;
}

TEST(MatchingTargets, LargestCosts) {
  const Pair pair{opposed_pair({40, 9})};
  for (const int window_px : {21, 29, 31, 33, 41}) {
    MatchingConfig config{config_of(window_px, 33)};
    config.uniqueness = 1;
    config.texture = 0;
    expect_equal_to_reference(pair, plain_plane, config, {2});
  }
}

// Windows beside those at which sums of costs and places outgrow 16 bits, with few and many shifts.
TEST(MatchingTargets, SumsThatFillTheirBits) {
  std::mt19937 generator{113};
  for (const int window_px : {15, 17, 21, 23, 33, 35}) {
    for (const int disparities : {16, 64, 65, 100, 192, 256}) {
      MatchingConfig config{config_of(window_px, disparities)};
      config.texture = 0;
      config.uniqueness = disparities % 2 == 0 ? 0 : 0.1;
      expect_equal_to_reference(opposed_pair({11, 1}), plain_plane, config, {1});
      config.uniqueness = disparities % 2 == 0 ? 0.1 : 0;
      expect_equal_to_reference(noise_pair({27, 1}, generator), rolled_plane, config, {2});
    }
  }
}

// Sums of texture, and least ones, that 16 bits hold and do not.
TEST(MatchingTargets, LargestTextures) {
  std::mt19937 generator{149};
  MatchingConfig config{config_of(41, 16)};
  for (const double texture : {38.9, 39.0, 80.0, 85.0}) {
    config.texture = texture;
    expect_equal_to_reference(noise_pair({70, 4}, generator), plain_plane, config, {2});
  }
}

// A row or a column of pixels, and one pixel, in more parts than there are rows.
TEST(MatchingTargets, NarrowAndFlatImages) {
  std::mt19937 generator{127};
  for (const Size size : {Size{1, 1}, Size{1, 50}, Size{50, 1}, Size{2, 2}, Size{3, 50}}) {
    for (const int window_px : {3, 41}) {
      for (const int disparities : {1, 2, 256}) {
        const MatchingConfig config{config_of(window_px, disparities)};
        expect_equal_to_reference(noise_pair(size, generator), rolled_plane, config, {1, 2, 3, 8});
      }
    }
  }
}

MatchingConfig random_config(std::mt19937& generator) {
  const auto any_of = [&](auto... values) {
    const double choices[]{static_cast<double>(values)...};
    return choices[uniform_int(generator, 0, static_cast<int>(std::size(choices)) - 1)];
  };
  MatchingConfig config;
  config.window_px = 3 + 2 * uniform_int(generator, 0, uniform_int(generator, 0, 3) == 0 ? 19 : 6);
  config.disparities = uniform_int(generator, 2, uniform_int(generator, 0, 3) == 0 ? 256 : 70);
  config.uniqueness = any_of(0, 0.02, 0.1, 1);
  config.texture = any_of(0, 1, 20);
  config.cost_limit = any_of(0.2, 0.37, 1);
  config.left_right_px = static_cast<int>(any_of(0, 1, 255));
  config.speckle_px = static_cast<int>(any_of(0, 3, 60));
  config.road_speckle_px = static_cast<int>(any_of(0, 3, 60));
  config.subpixel = uniform_int(generator, 0, 3) != 0;
  return config;
}

// To search longer: --gtest_filter=*Random* --gtest_shuffle --gtest_repeat=1000, which seeds anew.
TEST(MatchingTargets, RandomSizesAndSettings) {
  std::mt19937 generator{131u + static_cast<unsigned>(testing::UnitTest::GetInstance()->random_seed())};
  for (int i{0}; i < 20; ++i) {
    const MatchingConfig config{random_config(generator)};
    const Size size{uniform_int(generator, 1, 90), uniform_int(generator, 1, 12)};
    const RoadPlane plane{uniform(generator, -20, 60), uniform(generator, -0.3, 0.3), uniform(generator, -1, 2), 0, 5};
    const bool is_noise{uniform_int(generator, 0, 1) == 0};
    expect_equal_to_reference(is_noise ? noise_pair(size, generator) : textured_pair(size, generator), plane, config,
                              {uniform_int(generator, 1, 8)});
  }
}

}  // namespace
}  // namespace stereogrid::test
