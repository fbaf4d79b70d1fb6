// SPDX-License-Identifier: Apache-2.0
#include "matching_run.hpp"

namespace stereogrid::test {
namespace {

// Its neighbours' costs say that the minimum is a quarter of a pixel on.
Candidate candidate(int shift, int cost, int has_rivals = 0) {
  const auto word = [](int value) { return static_cast<std::uint16_t>(value); };
  return {word(cost), word(has_rivals), word(cost + 40), word(cost + 20), static_cast<std::int16_t>(shift)};
}

struct Decision {
  float obstacle;
  float road;
};

struct Pixel {
  Candidate upright;
  Candidate level;
  bool textured{true};
};

// A row that begins at column 40 of the image, with the road at one disparity; nothing claims before.
std::vector<Decision> decide_all(const std::vector<Pixel>& pixels, const MatchingConfig& config, double road_px = 10) {
  constexpr int first{40};
  const int width{first + static_cast<int>(pixels.size())};
  RowCandidates candidates{width};
  std::vector<std::uint8_t> textured(static_cast<std::size_t>(width) + CandidateRow::padding, 0);
  for (int u{0}; u < width; ++u) {
    const Pixel pixel{u < first ? Pixel{candidate(-30000, 30000), candidate(-30000, 30000), false}
                                : pixels[static_cast<std::size_t>(u - first)]};
    candidates.upright.set(u, pixel.upright);
    candidates.level.set(u, pixel.level);
    textured[static_cast<std::size_t>(u)] = pixel.textured ? 1 : 0;
  }
  Matches matches{width, 1};
  ClassifyWorkspace space{width};
  classify_row({candidates, road_row({road_px, 0, 0, 0, 0}, 0), textured.data(), width, config.disparities,
                config.left_right_px, config.subpixel, confidence_model(config), matches.obstacle.row(0),
                matches.road.row(0), matches.confidence.row(0)},
               space);
  std::vector<Decision> decisions;
  for (int u{first}; u < width; ++u) decisions.push_back({matches.obstacle(u, 0), matches.road(u, 0)});
  return decisions;
}

Decision decide(const Candidate& upright, const Candidate& level, const MatchingConfig& config, double road_px = 10,
                bool textured = true) {
  return decide_all({{upright, level, textured}}, config, road_px)[0];
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

TEST(Deciding, AnUncertainWinnerIsNotReplacedByTheLoser) {
  const MatchingConfig config{permissive_config()};
  const auto nothing = [&](const Decision& decision) { return decision.obstacle == 0 && decision.road == 0; };
  EXPECT_TRUE(nothing(decide(candidate(12, 50, 1), candidate(-1, 60), config)));
  EXPECT_EQ(decide(candidate(12, 50), candidate(-1, 60, 1), config).obstacle, 12.25f);
  EXPECT_TRUE(nothing(decide(candidate(12, 60), candidate(-1, 50, 3), config)));
  EXPECT_TRUE(nothing(decide(candidate(12, 50), candidate(-1, 60), config, 10, false)));
}

TEST(Deciding, ARivalCostsLessThanTheShareMore) {
  EXPECT_EQ(highest_rival(50, 0), 50);  // a draw between two far shifts is never unique
  EXPECT_EQ(highest_rival(50, 102), 54);
  EXPECT_EQ(highest_rival(1024, 102), 1125);
  EXPECT_EQ(highest_rival(0, 102), 0);
}

// Three pixels look at the same place of the right image; the cheapest keeps it, and who agrees with it within a pixel.
TEST(Deciding, APlaceInTheRightImageBelongsToTheCheapestClaim) {
  MatchingConfig config{permissive_config()};
  config.subpixel = false;
  const Candidate none{candidate(-3, 500)};
  const auto claims = [&](int first, int second, int third) {
    return decide_all({{candidate(12, first), none}, {candidate(13, second), none}, {candidate(14, third), none}},
                      config);
  };
  std::vector<Decision> decisions{claims(50, 60, 70)};
  EXPECT_EQ(decisions[0].obstacle, 12);
  EXPECT_EQ(decisions[1].obstacle, 13);
  EXPECT_EQ(decisions[2].obstacle, 0);
  decisions = claims(70, 60, 50);
  EXPECT_EQ(decisions[0].obstacle, 0);
  EXPECT_EQ(decisions[2].obstacle, 14);
  config.left_right_px = 2;
  EXPECT_EQ(claims(70, 60, 50)[0].obstacle, 12);
  // a road pixel claims in the same image
  config.left_right_px = 1;
  decisions = decide_all({{candidate(16, 50), none},
                          {none, none},
                          {none, none},
                          {none, none},
                          {none, none},
                          {none, none},
                          {candidate(30, 900), candidate(12, 40)}},
                         config);
  EXPECT_EQ(decisions[0].obstacle, 0);
  EXPECT_EQ(decisions[6].road, 22);
  // nothing is seen beyond the right image's left border
  EXPECT_EQ(decide_all({{candidate(31, 50), none}}, config)[0].obstacle, 31);
  config.disparities = 64;
  EXPECT_EQ(decide_all({{candidate(41, 50), none}}, config)[0].obstacle, 0);
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
  const auto paint = [](Image<float>& image, int u, int v, int nu, int nv, float d) {
    for (const auto [i, j] : raster(u, u + nu, v, v + nv)) image(i, j) = d;
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
  Speckles{size, size}.remove({6, 6}, matches);
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

TEST(Speckles, SizesAreByLabel) {
  Matches matches{4, 4};
  matches.obstacle(0, 0) = matches.obstacle(1, 0) = 9;
  matches.road(0, 2) = matches.road(1, 2) = 9;
  Speckles{4, 4}.remove({2, 3}, matches);
  EXPECT_EQ(matches.obstacle(1, 0), 9);
  EXPECT_EQ(matches.road(1, 2), 0);
  Speckles{4, 4}.remove({3, 0}, matches);
  EXPECT_EQ(matches.obstacle(1, 0), 0);
}

TEST(Speckles, BandsMakeNoDifference) {
  constexpr int width{37};
  constexpr int height{23};
  std::mt19937 random{7};
  for (int round{0}; round < 200; ++round) {
    Matches whole{width, height};
    for (int i{0}; i < width * height; ++i) {
      const auto value = static_cast<int>(random() % 16);  // two thirds of the pixels in few, large and ragged patches
      if (value < 10) (value < 3 ? whole.road : whole.obstacle).data()[i] = static_cast<float>(5 + value % 2);
      if (value < 10) whole.confidence.data()[i] = 1;
    }
    // an empty stretch must not be bridged
    for (int v{8}; v < 8 + round % 6; ++v) {
      for (Image<float>* image : {&whole.road, &whole.obstacle, &whole.confidence})
        std::fill_n(image->row(v), width, 0.0f);
    }
    Matches cut{whole};
    Speckles{width, height}.remove({12, 12}, whole);
    const int bands{2 + round % 30};  // more than rows, too
    Speckles speckles{width, height, bands};
    const auto row = [&](int band) { return height * band / bands; };
    for (int band{0}; band < bands; ++band) speckles.find_patches(band, row(band), row(band + 1), cut);
    speckles.join_bands(cut);
    for (int band{0}; band < bands; ++band) speckles.remove_small(band, {12, 12}, cut);
    ASSERT_EQ(cut.road, whole.road) << bands << " bands";
    ASSERT_EQ(cut.obstacle, whole.obstacle) << bands << " bands";
    ASSERT_EQ(cut.confidence, whole.confidence) << bands << " bands";
  }
}

TEST(Speckles, ZeroKeepsEverything) {
  Matches matches{3, 3};
  matches.road(1, 1) = 4;
  Speckles{3, 3}.remove({}, matches);
  EXPECT_EQ(matches.road(1, 1), 4);
}

}  // namespace
}  // namespace stereogrid::test
