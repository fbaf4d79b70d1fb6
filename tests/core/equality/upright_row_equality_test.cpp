// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Obstacle pixels by vectors, on every instruction set of this machine, against plain loops.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "obstacles/segmentation/upright_row.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

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
