// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "baselines/baselines.hpp"
#include "baselines/columns.hpp"
#include "baselines_scene.hpp"

namespace stereogrid::research::testing {
namespace {

using ::testing::ElementsAre;

TEST(BestPath, FollowsTheCheapestStates) {
  Image<float> costs{4, 5, 1.0F};
  const int valley[5]{0, 1, 2, 2, 3};
  for (int column{0}; column < 5; ++column) costs(valley[column], column) = 0;
  EXPECT_THAT(best_path(costs, 0.1, 3), ElementsAre(0, 1, 2, 2, 3));
}

TEST(BestPath, PassesOverALoneOutlier) {
  Image<float> costs{9, 5, 1.0F};
  for (int column{0}; column < 5; ++column) costs(column == 2 ? 8 : 1, column) = 0;
  EXPECT_THAT(best_path(costs, 0.2, 9), ElementsAre(1, 1, 1, 1, 1));
  EXPECT_THAT(best_path(costs, 0.2, 1), ElementsAre(1, 1, 8, 1, 1)) << "a jump costs no more than one step";
}

TEST(BestPath, OfNothingIsNothing) {
  EXPECT_TRUE(best_path({}, 1, 1).empty());
}

float at(const Image<float>& cells, double x_m) {
  return around(cells, half_metre_grid, x_m, 0).largest;
}

TEST(LogOddsMap, StandsStillInTheWorld) {
  LogOddsMap map;
  const Image<float> first{
      map.update(DisparityScene{}.road().wall(0, 240, 12, 2.5).frame(), {100, 7, 0.5}, half_metre_grid)};
  EXPECT_GT(at(first, 12), 0.6F);
  EXPECT_LT(at(first, 9), 0.45F);
  // 4 m on, nothing is matched: the map keeps its state
  const Pose2 later{Pose2{100, 7, 0.5} * Pose2{4, 0, 0}};
  const Image<float> second{map.update(DisparityScene{}.frame(), later, half_metre_grid)};
  EXPECT_GT(at(second, 8), 0.6F);
  EXPECT_LT(at(second, 5), 0.45F);
  EXPECT_NEAR(at(second, 12), 0.5F, 1e-6F);
}

TEST(LogOddsMap, GrowsSurerWithEveryFrame) {
  LogOddsMap map{0.1};
  const DisparityScene scene{DisparityScene{}.road().wall(0, 240, 12, 2.5)};
  const Image<float> first{map.update(scene.frame(), {}, half_metre_grid)};
  const Image<float> second{map.update(scene.frame(), {}, half_metre_grid)};
  EXPECT_GT(at(second, 12), at(first, 12));
  EXPECT_LT(at(second, 9), at(first, 9));
}

}  // namespace
}  // namespace stereogrid::research::testing
