// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/ray_fan.hpp"
#include "support.hpp"

namespace stereogrid::evaluation::testing {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

constexpr GridGeometry unit_cells{0, 0, 1, 4, 3};

TEST(Fan, ARayPassesTheCellsBeforeItsEnd) {
  Fan fan{{0.5, 1.5}, {{1, 0}}, 10, 0.25};
  fan.add(0, 2.1, true);
  const RayCounts counts{fan.cast(unit_cells, {})};
  for (int ix{0}; ix < 4; ++ix) {
    EXPECT_EQ(counts.passes(ix, 1), ix < 2 ? 1 : 0) << ix;
    EXPECT_EQ(counts.hits(ix, 1), ix == 2 ? 1 : 0) << ix;
    EXPECT_EQ(counts.passes(ix, 0) + counts.passes(ix, 2) + counts.hits(ix, 0) + counts.hits(ix, 2), 0) << ix;
  }
}

TEST(Fan, ARayThatEndsOnTheRoadPassesItsLastCellToo) {
  Fan fan{{0.5, 1.5}, {{1, 0}}, 10, 0.25};
  fan.add(0, 2.1, false);
  fan.add(0, 2.1, false);
  const RayCounts counts{fan.cast(unit_cells, {})};
  for (int ix{0}; ix < 4; ++ix) EXPECT_EQ(counts.passes(ix, 1), ix < 3 ? 2 : 0) << ix;
  EXPECT_THAT(values_of(counts.hits), Each(0.0F));
}

TEST(Fan, GoesAcrossCellsAlongItsDirection) {
  // from (0.25, 0.25) with slope 1/2: cells (0,0) (1,0) (1,1) (2,1) (3,1) (3,2)
  Fan fan{{0.25, 0.25}, {{1, 0.5}}, 50, 0.25};
  fan.add(0, 40, true);
  const RayCounts counts{fan.cast(unit_cells, {})};
  const float expected[3][4]{{1, 1, 0, 0}, {0, 1, 1, 1}, {0, 0, 0, 1}};
  for (int iy{0}; iy < 3; ++iy) {
    for (int ix{0}; ix < 4; ++ix) EXPECT_EQ(counts.passes(ix, iy), expected[iy][ix]) << ix << " " << iy;
  }
}

TEST(Fan, LiesInTheGridWhereThePosePutsIt) {
  Fan fan{{0, 0}, {{1, 0}}, 10, 0.25};
  fan.add(0, 1.6, true);
  // along y from (3.5, 0.5)
  const RayCounts counts{fan.cast(unit_cells, {3.5, 0.5, 1.5707963267948966})};
  EXPECT_EQ(counts.passes(3, 0), 1);
  EXPECT_EQ(counts.passes(3, 1), 1);
  EXPECT_EQ(counts.hits(3, 2), 1);
  EXPECT_EQ(std::accumulate(counts.hits.begin(), counts.hits.end(), 0.0F), 1);
}

TEST(Fan, WhatEndsBeyondItsLengthOnlyPasses) {
  Fan fan{{0.5, 0.5}, {{1, 0}}, 5, 0.25};
  fan.add(0, 1e6, true);
  const RayCounts counts{fan.cast(unit_cells, {})};
  for (int ix{0}; ix < 4; ++ix) EXPECT_EQ(counts.passes(ix, 0), 1) << ix;
  EXPECT_THAT(values_of(counts.hits), Each(0.0F));
}

TEST(LogOdds, AreClampedAndHitsOutweighPasses) {
  RayCounts counts{Image<float>{4, 1}, Image<float>{4, 1}};
  counts.hits(0, 0) = 5;
  counts.passes(0, 0) = 10;
  counts.passes(1, 0) = 10;
  counts.hits(2, 0) = 1e6F;
  const LogOddsParameters parameters{
      .any_hit = 1, .hit = 0.1, .any_pass = 0.5, .pass = 0.01, .points_min = 2, .lowest = -4, .highest = 3};
  EXPECT_THAT(values_of(log_odds_of(counts, parameters)),
              ElementsAre(::testing::FloatEq(1.4F), ::testing::FloatEq(-0.6F), 3.0F, 0.0F));
}

/// A ring of returns on the road and a post, in the camera's frame: the lidar stands on the camera.
std::vector<CameraPoint> sweep_with_post() {
  std::vector<CameraPoint> points;
  for (int row{0}; row < 12; ++row) {
    for (int i{-200}; i <= 200; ++i) points.push_back({0.02 * i, 1.5, 4.0 + 0.5 * row});
  }
  for (int i{-5}; i <= 5; ++i) {
    for (int k{0}; k < 4; ++k) points.push_back({0.03 * i, 0.3 + 0.2 * k, 8.25});
  }
  return points;
}

TEST(LidarGrid, HitsAndFreeRays) {
  const std::vector<CameraPoint> points{sweep_with_post()};
  const Image<float> cells{lidar_grid(points, {0, 0, 0}, small_rig(), half_metre_grid, 1.5)};
  EXPECT_GT(around(cells, half_metre_grid, 8.25, 0, 0.3).largest, 0.9F);
  EXPECT_LT(around(cells, half_metre_grid, 6, 2, 0.5).largest, 0.2F);
  EXPECT_EQ(around(cells, half_metre_grid, 15, 0, 0.5).largest, 0.5F);
}

TEST(LidarGrid, OfNoReturnsIsUnknown) {
  EXPECT_THAT(values_of(lidar_grid({}, {0, 0, 0}, small_rig(), half_metre_grid, 1.5)), Each(0.5F));
}

}  // namespace
}  // namespace stereogrid::evaluation::testing
