// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "matching_run.hpp"

namespace stereogrid::test {
namespace {

Candidate candidate(int shift, int cost, int runner_up = 1000) {
  return {static_cast<std::uint16_t>(cost), static_cast<std::uint16_t>(runner_up), static_cast<std::int16_t>(shift),
          true, 0.25f};
}

struct Decision {
  float obstacle;
  float road;
};

// One pixel with the road at 10 px.
Decision decide(const Candidate& upright, const Candidate& level, const MatchingConfig& config, double road_px = 10,
                bool textured = true) {
  MatchingSpace space{1, 1};
  Matches matches{1, 1};
  space.upright(0, 0) = upright;
  space.level(0, 0) = level;
  space.textured(0, 0) = textured ? 1 : 0;
  decide_row(0, {road_px, 0, 0, 0, 0}, config, space, matches);
  return {matches.obstacle(0, 0), matches.road(0, 0)};
}

TEST(Deciding, TheCheaperHypothesisGivesLabelAndDisparity) {
  const MatchingConfig config{permissive_config()};
  const Decision obstacle{decide(candidate(12, 50), candidate(-1, 60), config)};
  EXPECT_EQ(obstacle.obstacle, 12.25f);
  EXPECT_EQ(obstacle.road, 0);
  const Decision road{decide(candidate(12, 60), candidate(-1, 50), config)};
  EXPECT_EQ(road.obstacle, 0);
  EXPECT_EQ(road.road, 9.25f);
  // a draw: upright, which searches more
  EXPECT_EQ(decide(candidate(12, 50), candidate(-1, 50), config).obstacle, 12.25f);
  MatchingConfig whole{config};
  whole.subpixel = false;
  EXPECT_EQ(decide(candidate(12, 50), candidate(-1, 60), whole).obstacle, 12);
  EXPECT_EQ(decide(candidate(12, 60), candidate(-1, 50), whole, 10.125).road, 9.125f);
}

TEST(Deciding, ADoubtfulWinnerIsNotReplacedByTheLoser) {
  MatchingConfig config{permissive_config()};
  config.uniqueness = 0.1;
  const auto nothing = [&](const Decision& decision) { return decision.obstacle == 0 && decision.road == 0; };
  EXPECT_TRUE(nothing(decide(candidate(12, 50, 54), candidate(-1, 60), config)));
  EXPECT_EQ(decide(candidate(12, 50, 56), candidate(-1, 60), config).obstacle, 12.25f);
  EXPECT_TRUE(nothing(decide(candidate(12, 60), candidate(-1, 50, 54), config)));
  Candidate contradicted{candidate(12, 50)};
  contradicted.consistent = false;
  EXPECT_TRUE(nothing(decide(contradicted, candidate(-1, 60), config)));
  contradicted = candidate(-1, 50);
  contradicted.consistent = false;
  EXPECT_TRUE(nothing(decide(candidate(12, 60), contradicted, config)));
  EXPECT_TRUE(nothing(decide(candidate(12, 50), candidate(-1, 60), config, 10, false)));
  // a draw between two far shifts is never unique
  config.uniqueness = 0;
  EXPECT_TRUE(nothing(decide(candidate(12, 50, 50), candidate(-1, 60), config)));
}

TEST(Deciding, ThereIsNoRoadAboveTheHorizonOrBeyondTheSearch) {
  const MatchingConfig config{permissive_config()};
  EXPECT_EQ(decide(candidate(12, 60), candidate(0, 50), config, 0.5).obstacle, 12.25f);
  EXPECT_EQ(decide(candidate(12, 60), candidate(0, 50), config, -3).obstacle, 12.25f);
  EXPECT_EQ(decide(candidate(12, 60), candidate(-3, 50), config, 2).road, 0);    // −0.75
  EXPECT_EQ(decide(candidate(12, 60), candidate(0, 50), config, 31.3).road, 0);  // 31.55 would round to bin 32
  EXPECT_EQ(decide(candidate(12, 60), candidate(0, 50), config, 31.125).road, 31.375f);
}

TEST(Speckles, SmallPatchesGoAndLargeOnesStay) {
  constexpr int size{12};
  Matches matches{size, size};
  Image<int> patch{size, size};
  const auto paint = [](Image<float>& image, int u, int v, int nu, int nv, float d) {
    for (int j{v}; j < v + nv; ++j) {
      for (int i{u}; i < u + nu; ++i) image(i, j) = d;
    }
  };
  paint(matches.obstacle, 0, 0, 3, 2, 9);  // 6 pixels
  paint(matches.obstacle, 5, 0, 5, 1, 9);  // 5 pixels
  paint(matches.obstacle, 0, 4, 3, 1, 9);  // 3 and 3 pixels, one pixel of disparity apart: one patch
  paint(matches.obstacle, 0, 5, 3, 1, 10);
  paint(matches.obstacle, 5, 4, 3, 1, 9);  // 3 and 3 pixels, more than one apart: two patches
  paint(matches.obstacle, 5, 5, 3, 1, 10.5);
  paint(matches.obstacle, 0, 8, 3, 1, 9);  // 3 and 3 pixels of two labels: two patches
  paint(matches.road, 0, 9, 3, 1, 9);
  paint(matches.road, 6, 8, 3, 2, 9);  // 6 pixels of road
  remove_speckles(6, patch, matches);
  EXPECT_EQ(matches.obstacle(2, 1), 9);
  EXPECT_EQ(matches.obstacle(7, 0), 0);
  EXPECT_EQ(matches.obstacle(1, 4), 9);
  EXPECT_EQ(matches.obstacle(1, 5), 10);
  EXPECT_EQ(matches.obstacle(6, 4), 0);
  EXPECT_EQ(matches.obstacle(6, 5), 0);
  EXPECT_EQ(matches.obstacle(1, 8), 0);
  EXPECT_EQ(matches.road(1, 9), 0);
  EXPECT_EQ(matches.road(7, 9), 9);
}

TEST(Speckles, ZeroKeepsEverything) {
  Matches matches{3, 3};
  Image<int> patch{3, 3};
  matches.road(1, 1) = 4;
  remove_speckles(0, patch, matches);
  EXPECT_EQ(matches.road(1, 1), 4);
}

}  // namespace
}  // namespace stereogrid::test
