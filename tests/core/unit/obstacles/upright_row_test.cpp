// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/columns.hpp"

#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

// On level ground, seen from 1 m above it with the horizon in this row's place: every disparity is upright.
TEST(UprightRow, WhatLiesBetweenTwoSurfacesIsLeftOut) {
  const UprightRow limits{
      .nearest_px = 64, .farthest_px = 1, .road_px = 0, .road_per_px = 0, .lowest_share = 0.8f, .highest_share = -1};
  std::vector<float> row(40, 20.0f);
  std::fill(row.begin() + 20, row.end(), 10.0f);
  row[19] = 15;  // a window across the edge
  row[3] = 15;   // between nothing
  row[8] = 0;
  UprightPixels pixels;
  plain::find_upright(row.data(), 40, 0, 40, limits, pixels);
  std::vector<int> left_out;
  for (int u{0}, i{0}; u < 40; ++u) {
    if (i < pixels.size && pixels.columns[i] == u) {
      EXPECT_EQ(pixels.disparities[i++], row[static_cast<std::size_t>(u)]);
    } else {
      left_out.push_back(u);
    }
  }
  EXPECT_THAT(left_out, ::testing::ElementsAre(8, 19));
}

TEST(UprightRow, WhatIsNoHigherThanTheRoadOrTooFarIsNone) {
  const UprightRow limits{.nearest_px = 64,
                          .farthest_px = 4,
                          .road_px = 8,
                          .road_per_px = 0.1f,
                          .lowest_share = 0.8f,
                          .highest_share = 0.5f};
  for (const auto& [u, d, is_upright] : {std::tuple{0, 10.1f, true},
                                         {0, 9.9f, false},
                                         {5, 10.7f, true},
                                         {5, 10.5f, false},
                                         {0, 63.0f, true},
                                         {0, 64.0f, false},
                                         {-50, 4.1f, true},
                                         {-50, 4.0f, false}}) {
    EXPECT_EQ(limits.is_upright(u, d), is_upright) << u << " " << d;
  }
  EXPECT_TRUE(limits.is_below_highest(0, 10.1f));
  EXPECT_FALSE(limits.is_below_highest(4, 63));
}

struct Random {
  std::mt19937 generator;

  float between(float least, float most) { return std::uniform_real_distribution<float>{least, most}(generator); }
};

// Surfaces, steps between them, and nothing here and there.
std::vector<float> any_row(Random& random, int width) {
  std::vector<float> row(static_cast<std::size_t>(width));
  float surface{20};
  for (float& d : row) {
    if (random.between(0, 1) < 0.1f) surface = random.between(2, 40);
    d = random.between(0, 1) < 0.2f ? 0 : surface + random.between(-1, 1);
  }
  return row;
}

void expect_equal(const UprightPixels& expected, const UprightPixels& actual) {
  ASSERT_EQ(expected.size, actual.size);
  for (int i{0}; i < expected.size; ++i) {
    ASSERT_EQ(expected.columns[i], actual.columns[i]) << i;
    ASSERT_EQ(expected.disparities[i], actual.disparities[i]) << i;
  }
}

// Vectors against plain loops.
TEST(UprightRowEquality, OnEveryInstructionSet) {
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    SCOPED_TRACE(name_of_target(target));
    Random random{std::mt19937{4}};
    int found{0};
    for (const int width : {1, 4, 9, 15, 16, 17, 26, 27, 133, 256, 261, 700}) {
      for (int round{0}; round < 20; ++round) {
        const std::vector<float> row(any_row(random, width));
        const UprightRow limits{.nearest_px = 38,
                                .farthest_px = 4,
                                .road_px = random.between(-5, 20),
                                .road_per_px = random.between(-0.02f, 0.02f),
                                .lowest_share = 0.8f,
                                .highest_share = 0};
        const int begin{static_cast<int>(random.generator() % static_cast<unsigned>(width))};
        const int end{std::min(begin + UprightPixels::most, width)};
        UprightPixels expected;
        plain::find_upright(row.data(), width, begin, end, limits, expected);
        UprightPixels actual;
        find_upright(row.data(), width, begin, end, limits, actual);
        expect_equal(expected, actual);
        found += actual.size;
      }
    }
    EXPECT_GT(found, 3000);
  }
}

}  // namespace

}  // namespace stereogrid::test
