// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "observation/u_disparity/model.hpp"
#include "support.hpp"
#include "targets.hpp"
#include "u_disparity_run.hpp"

namespace stereogrid::test {
namespace {

struct Case {
  int width;
  int height;
  int disparities;
  double cy_px;  // near the horizon
  Ground ground;
  BinConfig config;
};

Case random_case(std::mt19937& generator) {
  Case c{};
  c.width = uniform_int(generator, 1, 150);
  c.height = uniform_int(generator, 1, 70);
  c.disparities = uniform_int(generator, 2, 70);
  // the horizon above, within and below the image; H below and above h
  c.cy_px = uniform(generator, -30, c.height + 30);
  c.ground = {uniform(generator, 0.5, 2.5), uniform(generator, -0.1, 0.1), uniform(generator, -0.3, 0.3), false};
  c.config.obstacle_height_m = uniform(generator, 0.3, 2.5);
  c.config.obstacle_min_height_m = uniform_int(generator, 0, 1) * uniform(generator, 0, 0.5);
  c.config.follow_roll = uniform_int(generator, 0, 1) == 0;
  c.config.false_positive = uniform(generator, 0.001, 0.3);
  c.config.false_negative = uniform(generator, 0.001, 0.3);
  c.config.tau_obstacle = uniform(generator, 0.05, 1);
  c.config.tau_road = uniform(generator, 0.05, 1);
  c.config.sigma_disparity = uniform(generator, 0, 1.2);
  c.config.sigma_column = uniform(generator, 0, 3);
  c.config.road_rays = uniform_int(generator, 0, 1) == 0 ? RoadRays::none : RoadRays::visible;
  c.config.small_count_guard = uniform_int(generator, 0, 3);
  c.config.left_border = uniform_int(generator, 0, 1) == 0;
  return c;
}

Rig rig_of(const Case& c) {
  return {c.width, c.height, 150, c.width / 2.0, c.cy_px, 0.4, c.ground.height_m, 0, 0};
}

Matches random_matches(const Case& c, std::mt19937& generator) {
  Matches matches{c.width, c.height};
  for (std::size_t i{0}; i < matches.road.size(); ++i) {
    const double kind{uniform(generator, 0, 1)};
    const auto disparity{static_cast<float>(uniform(generator, 0.1, c.disparities - 0.51))};
    if (kind < 0.4) matches.obstacle.data()[i] = disparity;
    if (kind > 0.7) matches.road.data()[i] = disparity;
    matches.confidence.data()[i] = static_cast<float>(std::max(uniform(generator, -0.2, 1), 0.0));
  }
  return matches;
}

void expect_equality(unsigned seed, int rounds) {
  std::mt19937 generator{seed};
  Reference reference;
  for (int round{0}; round < rounds; ++round) {
    const Case c{random_case(generator)};
    const Matches matches{random_matches(c, generator)};
    const int window_px{1 + 2 * uniform_int(generator, 1, 10)};
    Cpu cpu{1 + round % 2};
    const StageImages slow{counted(reference, matches, rig_of(c), c.ground, c.config, c.disparities, window_px)};
    const StageImages fast{counted(cpu, matches, rig_of(c), c.ground, c.config, c.disparities, window_px)};
    const auto where = testing::Message()
                       << "round " << round << ": " << c.width << " × " << c.height << " × " << c.disparities;
    EXPECT_EQ(slow.possible, fast.possible) << where;
    EXPECT_EQ(count_differences(slow.visible, fast.visible), 0) << where;
    EXPECT_EQ(count_differences(slow.observed, fast.observed), 0) << where;
    EXPECT_EQ(count_differences(slow.visibility, fast.visibility), 0) << where;
    EXPECT_EQ(count_differences(slow.obstacle_confidence, fast.obstacle_confidence), 0) << where;
    EXPECT_EQ(count_differences(slow.road_confidence, fast.road_confidence), 0) << where;
    EXPECT_EQ(count_differences(slow.occupancy, fast.occupancy), 0) << where;
    EXPECT_EQ(count_differences(slow.occupancy_smooth, fast.occupancy_smooth), 0) << where;
  }
}

TEST(UDisparityEquality, CpuEqualsReference) {
  expect_equality(31, 60);
}

TEST(UDisparityEquality, WithEveryInstructionSet) {
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    SCOPED_TRACE(name_of_target(target));
    expect_equality(32, 20);
  }
}

TEST(UDisparityProperties, CountsAndProbabilitiesStayInTheirBounds) {
  std::mt19937 generator{37};
  Cpu cpu{2};
  for (int round{0}; round < 40; ++round) {
    const Case c{random_case(generator)};
    const StageImages stages{
        counted(cpu, random_matches(c, generator), rig_of(c), c.ground, c.config, c.disparities, 9)};
    BinRows bins{c.width, c.height, c.disparities};
    bins.place(rig_of(c), c.ground, c.config);
    for (int d{0}; d < c.disparities; ++d) {
      const RowRange rows{bins.rows[static_cast<std::size_t>(d)]};
      // without roll the rows of all columns are those of the column u0
      ASSERT_EQ(stages.possible[static_cast<std::size_t>(d)], possible_in_column(rows.first, rows.last, 0, c.height));
      for (int u{0}; u < c.width; ++u) {
        const int shift{bins.shift[static_cast<std::size_t>(u)]};
        ASSERT_TRUE(c.config.follow_roll || shift == 0);
        ASSERT_LE(stages.observed(u, d), stages.visible(u, d));
        ASSERT_LE(stages.visible(u, d), possible_in_column(rows.first, rows.last, shift, c.height));
        for (const Image<float>* image : {&stages.visibility, &stages.obstacle_confidence, &stages.road_confidence}) {
          ASSERT_GE((*image)(u, d), 0);
          ASSERT_LE((*image)(u, d), 1);
        }
        if (d > 0 && stages.occupancy(u, d) != 0.5f) {
          ASSERT_GE(stages.occupancy(u, d), static_cast<float>(c.config.false_negative));
          ASSERT_LE(stages.occupancy(u, d), static_cast<float>(1 - c.config.false_positive) + 1e-6f);
        }
        ASSERT_GE(stages.occupancy_smooth(u, d), 0);
        ASSERT_LE(stages.occupancy_smooth(u, d), 1);
      }
    }
  }
}

// An obstacle pixel where there was nothing, or road, or an obstacle farther away or nearer: r_O of its own bin grows
// from N_O/(N_V + guard) to at least (N_O + 1)/(N_V + 1 + guard), so P(C) cannot fall.
TEST(UDisparityProperties, AnObstaclePixelNeverLowersTheConfidenceOfItsBin) {
  std::mt19937 generator{41};
  Cpu cpu{1};
  int raised{0};
  for (int round{0}; round < 300; ++round) {
    Case c{random_case(generator)};
    c.config.obstacle_min_height_m = 0;
    c.width = uniform_int(generator, 1, 5);
    Matches matches{random_matches(c, generator)};
    const int u{uniform_int(generator, 0, c.width - 1)};
    const int v{uniform_int(generator, 0, c.height - 1)};
    const int d{uniform_int(generator, 1, c.disparities - 1)};
    const StageImages before{counted(cpu, matches, rig_of(c), c.ground, c.config, c.disparities, 9)};
    matches.road(u, v) = 0;
    matches.obstacle(u, v) = static_cast<float>(d);
    const StageImages after{counted(cpu, matches, rig_of(c), c.ground, c.config, c.disparities, 9)};
    ASSERT_GE(after.obstacle_confidence(u, d), before.obstacle_confidence(u, d));
    raised += after.obstacle_confidence(u, d) > before.obstacle_confidence(u, d) ? 1 : 0;
  }
  EXPECT_GT(raised, 50);
}

// Pixels hidden by a nearer obstacle must not count for the bins in front of it, and the other way round.
TEST(UDisparityProperties, ARayIsSeenByEveryBinInFrontOfItsEnd) {
  std::mt19937 generator{43};
  Cpu cpu{1};
  for (int round{0}; round < 100; ++round) {
    Case c{random_case(generator)};
    c.width = 1;
    c.config.follow_roll = false;
    const int v{uniform_int(generator, 0, c.height - 1)};
    const int end{uniform_int(generator, 1, c.disparities - 1)};
    Matches matches{c.width, c.height};
    matches.obstacle(0, v) = static_cast<float>(end);
    const StageImages stages{counted(cpu, matches, rig_of(c), c.ground, c.config, c.disparities, 9)};
    for (int d{0}; d < c.disparities; ++d) {
      const RowRange rows{possible_rows(rig_of(c), c.ground, c.config.obstacle_height_m, d, c.height)};
      const bool possible{v >= rows.first && v <= rows.last};
      const RowRange upright{rows_between(rig_of(c), c.ground, c.config.obstacle_min_height_m, 10, d)};
      ASSERT_EQ(stages.visible(0, d), possible && d >= end ? 1 : 0);
      ASSERT_EQ(stages.observed(0, d), possible && d == end && v <= upright.last ? 1 : 0);
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
