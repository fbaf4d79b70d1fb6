// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Bins finer than a pixel. That they are the same on the CPU: u_disparity_properties_test.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "backend/reference.hpp"
#include "projection/projection.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"
#include "support.hpp"
#include "u_disparity/model.hpp"
#include "u_disparity_run.hpp"

namespace stereogrid::test {
namespace {

// v_hor = 0, H = 1 m, b = 0.1 m: the road at disparity d lies in row 10·d; with h = 1 m rows 0 … 10·d belong to it.
Rig tall_rig() {
  return {3, 100, 100, 1, 0, 0.1, 1, 0, 0};
}

constexpr Ground tall_ground{1, 0, 0, false};
constexpr int disparities{8};

UDisparityConfig fine_config(int bins_per_px) {
  UDisparityConfig config;
  config.obstacle_height_m = 1;
  config.obstacle_min_height_m = 0;
  config.follow_roll = false;
  config.small_count_guard = 0;
  config.left_border = false;
  config.sigma_disparity = config.sigma_column = 0;
  config.bins_per_px = bins_per_px;
  return config;
}

Matches wall_at(float disparity, int rows = 16) {
  Matches matches{3, 100};
  for (int v{0}; v < rows; ++v) matches.obstacle(1, v) = disparity;
  return matches;
}

StageImages fine_count(const Matches& matches, const UDisparityConfig& config) {
  Reference reference;
  return counted(reference, matches, tall_rig(), tall_ground, config, disparities, 3);
}

TEST(FineBins, ABinHasItsOwnRows) {
  const StageImages stages{fine_count(Matches{3, 100}, fine_config(4))};
  ASSERT_EQ(stages.possible.size(), 4u * disparities);
  EXPECT_EQ(stages.possible[8], 21);   // d = 2: rows 0 … 20
  EXPECT_EQ(stages.possible[9], 23);   // d = 2.25: rows 0 … 22
  EXPECT_EQ(stages.possible[11], 28);  // d = 2.75: rows 0 … 27
}

TEST(FineBins, ASurfaceFillsTheBinsOfAPixel) {
  // ½ px wide bins; disparity 3 is bin 6, the support half a bin further to both sides
  const StageImages half{fine_count(wall_at(3), fine_config(2))};
  const int observed_half[]{0, 8, 16, 8, 0};
  const int visible_half[]{0, 8, 16, 16, 16};
  for (int i{0}; i < 5; ++i) {
    EXPECT_EQ(half.observed(1, 4 + i), observed_half[i]) << 4 + i;
    EXPECT_EQ(half.visible(1, 4 + i), visible_half[i]) << 4 + i;
    EXPECT_EQ(half.visible(0, 4 + i), 0);
  }
  // ¼ px: bin 12, one and a half bins
  const StageImages quarter{fine_count(wall_at(3), fine_config(4))};
  const int observed_quarter[]{0, 8, 16, 16, 16, 8, 0};
  for (int i{0}; i < 7; ++i) EXPECT_EQ(quarter.observed(1, 9 + i), observed_quarter[i]) << 9 + i;
  // so r_O is 1 in its middle, as it is with whole pixels, where the disparity happens to be one
  EXPECT_FLOAT_EQ(quarter.obstacle_confidence(1, 12), fine_count(wall_at(3), fine_config(1)).obstacle_confidence(1, 3));
}

TEST(FineBins, ADisparityBetweenTwoBinsBelongsToBoth) {
  // 3.125 px lies between the bins 12 and 13 of ¼ px, 3.1875 at three quarters
  const StageImages middle{fine_count(wall_at(3.125f), fine_config(4))};
  const int observed_middle[]{0, 0, 16, 16, 16, 16, 0, 0};
  for (int i{0}; i < 8; ++i) EXPECT_EQ(middle.observed(1, 9 + i), observed_middle[i]) << 9 + i;
  const StageImages nearer{fine_count(wall_at(3.1875f), fine_config(4))};
  const int observed_nearer[]{0, 0, 12, 16, 16, 16, 4, 0};
  for (int i{0}; i < 8; ++i) EXPECT_EQ(nearer.observed(1, 9 + i), observed_nearer[i]) << 9 + i;
}

TEST(FineBins, WhatStandsBehindAnObstacleIsHidden) {
  Matches matches{wall_at(5)};
  for (int v{0}; v < 8; ++v) matches.obstacle(1, v) = 3;  // seen above it
  const StageImages stages{fine_count(matches, fine_config(4))};
  EXPECT_EQ(stages.visible(1, 12), 8);
  EXPECT_EQ(stages.observed(1, 12), 8);
  EXPECT_EQ(stages.visible(1, 16), 8) << "between the two";
  EXPECT_EQ(stages.observed(1, 16), 0);
  EXPECT_EQ(stages.visible(1, 20), 16);
  EXPECT_EQ(stages.observed(1, 20), 8);
}

TEST(FineBins, RoadKeepsItsNeighbourhoodOfThreePixels) {
  // as dense as it is on a real road: a road pixel in each disparity, in fewer than each bin
  Matches matches{3, 100};
  for (int u{0}; u < 3; ++u) {
    for (int d{1}; d < disparities; ++d) matches.road(u, 10 * d) = static_cast<float>(d);
  }
  for (const int per_px : {1, 2, 4}) {
    const StageImages stages{fine_count(matches, fine_config(per_px))};
    for (int k{2 * per_px}; k <= 6 * per_px; ++k) {
      EXPECT_FLOAT_EQ(stages.road_confidence(1, k), 1) << per_px << " " << k;
    }
  }
  matches.road(1, 40) = 0;
  EXPECT_LT(fine_count(matches, fine_config(4)).road_confidence(1, 16), 1);
}

TEST(FineBins, TheLeftBorderIsThatOfTheDisparity) {
  UDisparityConfig config{fine_config(4)};
  config.left_border = true;
  const StageImages stages{fine_count(wall_at(3), config)};  // a window of 3 px: unknown where u < d + 1
  EXPECT_NE(stages.occupancy(2, 4), 0.5f);                   // d = 1
  EXPECT_EQ(stages.occupancy(2, 5), 0.5f);                   // d = 1.25
  EXPECT_NE(fine_count(wall_at(3), fine_config(4)).occupancy(2, 5), 0.5f);
}

TEST(FineBins, LieBetweenThoseOfPixelsOnTheGround) {
  const Rig rig{201, 100, 400, 100, 50, 0.25, 1.5, 0, 0};  // f·b = 100 px·m
  const BinGeometry bins{rig, 4};
  EXPECT_DOUBLE_EQ(bins.nearest_x(40), 100 / 10.125);
  EXPECT_DOUBLE_EQ(bins.farthest_x(40), 100 / 9.875);
  EXPECT_DOUBLE_EQ(bins.disparity(10), 40);
  Reference reference;
  const GridGeometry grid{8, -0.1, 0.1, 40, 2};
  Image<float> occupancy{201, 120, 0.1f};
  for (int u{0}; u < 201; ++u) occupancy(u, 42) = 0.9f;  // 10.5 px: 9.41 … 9.64 m
  ProjectionSpace space{201, 120};
  Image<float> cells{grid.nx, grid.ny};
  project(reference, occupancy.view(), bins, {grid}, space, cells.view());
  for (int ix{0}; ix < grid.nx; ++ix) EXPECT_EQ(cells(ix, 0), ix >= 14 && ix <= 16 ? 0.9f : 0.1f) << ix;
}

TEST(FineBins, ThePipelineHasThemAndItsBackEndsAgree) {
  const Rig rig{160, 90, 120, 80, 40, 0.4, 1.5, 0, 0};
  Config config;
  config.grid = {12, 12, 0.3};
  config.matching.disparities = 24;
  config.u_disparity.bins_per_px = 2;
  std::mt19937 generator{61};
  StereoFrame frame;
  frame.name = "0";
  frame.left = frame.right = Image<std::uint8_t>{rig.width_px, rig.height_px};
  for (std::uint8_t& pixel : frame.left) pixel = static_cast<std::uint8_t>(uniform_int(generator, 0, 255));
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u + 6 < rig.width_px; ++u) frame.right(u, v) = frame.left(u + 6, v);  // a wall at 6 px
  }
  Pipeline cpu{config, rig, {.threads = 2}};
  Pipeline reference{config, rig, {.back_end = BackEnd::reference}};
  const FrameResult& fast{cpu.process(frame)};
  const FrameResult& slow{reference.process(frame)};
  EXPECT_EQ(fast.stages.bins_per_px, 2);
  EXPECT_EQ(fast.stages.occupancy.height(), 48);
  EXPECT_EQ(fast.stages.possible.size(), 48u);
  EXPECT_EQ(count_differences(fast.observed, slow.observed), 0);
  EXPECT_GT(fast.stages.obstacle_confidence(100, 12), 0.9);
  config.u_disparity.bins_per_px = 3;
  EXPECT_THROW((Pipeline{config, rig}), ConfigError);
}

}  // namespace
}  // namespace stereogrid::test
