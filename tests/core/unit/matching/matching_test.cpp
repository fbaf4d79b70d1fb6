// SPDX-License-Identifier: Apache-2.0
#include "matching_run.hpp"

namespace stereogrid::test {
namespace {

constexpr int width{160};
constexpr int height{80};

Image<std::uint8_t> left_image(const Texture& texture) {
  return textured_image(texture, width, height, [](int u, int) { return u; });
}

// Right image for a disparity that depends on the row alone: left u is right u − d.
Image<std::uint8_t> right_image(const Texture& texture, const std::function<double(int)>& disparity_of_row) {
  return textured_image(texture, width, height, [&](int u, int v) { return u + disparity_of_row(v); });
}

// A horizontal road whose horizon is row 5.
const RoadPlane road{0.3 * (height / 2.0 - 5), 0, 0.3, width / 2.0, height / 2.0};

TEST(Matching, RoadThatLiesOutsideTheRightImageHasItsBorder) {
  const std::vector<std::uint8_t> row{10, 10, 20, 30, 40, 40, 99, 99, 99};
  const auto seen = [&](int u, double disparity) {
    return sheared(row.data() + 1, 4, u, {static_cast<std::int32_t>(disparity * 65536), 0});
  };
  EXPECT_EQ(seen(2, 1), 20);
  EXPECT_EQ(seen(2, 0.5), 25);
  EXPECT_EQ(seen(1, 4), 10);
  EXPECT_EQ(seen(3, -3), 40);
}

double road_of_row(int v) {
  return std::max(road.disparity(0, v), 0.0);
}

TEST(Matching, FindsAConstantShift) {
  const Texture texture{1};
  Cpu cpu{2};
  for (const int shift : {1, 7, 20, 31}) {
    const MatchRun run{cpu, left_image(texture), right_image(texture, [&](int) { return shift; }), no_road,
                       permissive_config()};
    const int half{permissive_config().window_px / 2};
    for (const auto [u, v] :
         raster(shift + half + short_census_half_u, width - half - short_census_half_u, 0, height)) {
      ASSERT_EQ(run.upright(u, v).shift, shift) << u << " " << v;
      ASSERT_EQ(run.upright(u, v).cost, 0);
      ASSERT_NEAR(run.matches.obstacle(u, v), shift, 0.25);
      ASSERT_EQ(run.matches.road(u, v), 0);
    }
  }
}

TEST(Matching, WholePixelsWithoutSubpixel) {
  const Texture texture{1};
  Cpu cpu{2};
  MatchingConfig config{permissive_config()};
  config.subpixel = false;
  const MatchRun run{cpu, left_image(texture), right_image(texture, [](int) { return 7.3; }), no_road, config};
  for (const auto [u, v] : raster(20, width - 20, 8, height - 8)) ASSERT_EQ(run.matches.obstacle(u, v), 7);
}

// A match from the left image's left border would lie outside the right image.
TEST(Matching, LeavesTheLeftBorderEmpty) {
  const Texture texture{2};
  Cpu cpu{2};
  constexpr int shift{20};
  MatchingConfig config{permissive_config()};
  config.uniqueness = 0.05;
  const MatchRun run{cpu, left_image(texture), right_image(texture, [](int) { return shift; }), no_road, config};
  int wrong{0};
  for (const auto [u, v] : raster(shift, height)) wrong += run.matches.obstacle(u, v) > 0 ? 1 : 0;
  EXPECT_LT(wrong, 0.05 * shift * height);
}

// Upright stripes of a period of 10 px with noise; their disparities lie between the whole pixels.
TEST(Matching, MarksPixelsOfARepeatingPattern) {
  std::mt19937 generator{5};
  const auto stripes = [&](double shift) {
    Image<std::uint8_t> image{width, height};
    for (const auto [u, v] : raster(width, height)) {
      image(u, v) = static_cast<std::uint8_t>(120 + 60 * std::sin((u + shift) * std::numbers::pi / 5) +
                                              uniform(generator, -3, 3));
    }
    return image;
  };
  Cpu cpu{1};
  for (const double shift : {3.6, 7.3, 12.5}) {
    const MatchRun run{cpu, stripes(0), stripes(shift), no_road, MatchingConfig{.disparities = 32}};
    for (int u{40}; u < width - 10; ++u) {
      int ambiguous{0};
      for (int v{0}; v < height; ++v) ambiguous += is_ambiguous(run.matches.obstacle(u, v)) ? 1 : 0;
      EXPECT_GT(ambiguous, height / 4) << shift << " " << u;
    }
  }
  EXPECT_FALSE(is_ambiguous(0.0f));
}

// Behind the left edge of a wall: a background 20 px farther, or with no disparity.
TEST(Matching, PixelsThatOnlyTheLeftCameraSeesAreNotAmbiguous) {
  const Texture wall{3};
  const Texture behind{4};
  constexpr int edge{80};
  constexpr int nearer{20};
  Cpu cpu{1};
  for (const int far : {0, 3}) {
    const auto seen = [&](int wall_px, int far_px) {
      Image<std::uint8_t> image{textured_image(behind, width, height, [&](int u, int) { return u + far_px; })};
      const auto front = textured_image(wall, width, height, [&](int u, int) { return u + wall_px; });
      for (int v{0}; v < height; ++v) {
        std::copy(front.row(v) + edge - wall_px, front.row(v) + width, image.row(v) + edge - wall_px);
      }
      return image;
    };
    const MatchRun run{cpu, seen(0, 0), seen(far + nearer, far), no_road, MatchingConfig{.disparities = 32}};
    int ambiguous{0};
    for (const auto [u, v] : raster(far + 10, edge, 0, height))
      ambiguous += is_ambiguous(run.matches.obstacle(u, v)) ? 1 : 0;
    EXPECT_LT(ambiguous, 0.02 * edge * height) << far;
  }
}

TEST(Matching, DisparityZeroIsNoMeasurement) {
  const Texture texture{3};
  Cpu cpu{1};
  const Image<std::uint8_t> image{left_image(texture)};
  const MatchRun run{cpu, image, image, no_road, permissive_config()};
  EXPECT_EQ(run.upright(80, 40).shift, 0);
  for (const float d : run.matches.obstacle) EXPECT_EQ(d, 0);
}

TEST(Matching, GainAndOffsetOfTheRightCameraDoNotMatter) {
  const Texture texture{4};
  Cpu cpu{2};
  const Image<std::uint8_t> left{left_image(texture)};
  const Image<std::uint8_t> right{right_image(texture, [](int v) { return v < 40 ? 9 : road_of_row(v); })};
  Image<std::uint8_t> brighter{right};
  for (std::uint8_t& pixel : brighter) {
    ASSERT_LT(pixel * 1.3 + 12, 255);
    pixel = static_cast<std::uint8_t>(pixel * 1.3 + 12.5);
  }
  const MatchRun plain{cpu, left, right, road, permissive_config()};
  const MatchRun gained{cpu, left, brighter, road, permissive_config()};
  for (std::size_t i{0}; i < plain.upright.size(); ++i) {
    ASSERT_EQ(plain.upright.data()[i].cost, gained.upright.data()[i].cost);
    ASSERT_EQ(plain.upright.data()[i].shift, gained.upright.data()[i].shift);
  }
  // sheared rows are interpolated and rounded, before or after the gain
  int changed{0};
  for (std::size_t i{0}; i < plain.matches.road.size(); ++i) {
    changed += std::abs(plain.matches.road.data()[i] - gained.matches.road.data()[i]) > 0.2f ? 1 : 0;
  }
  EXPECT_LT(changed, 0.01 * width * height);
}

TEST(Matching, NothingMatchesWithoutTexture) {
  Cpu cpu{2};
  MatchingConfig config{permissive_config()};
  const auto nothing_matched = [](const MatchRun& run) {
    for (std::size_t i{0}; i < run.matches.road.size(); ++i) {
      if (run.matches.road.data()[i] != 0 || run.matches.obstacle.data()[i] != 0) return false;
    }
    return true;
  };
  const Image<std::uint8_t> blank{width, height, 120};
  EXPECT_TRUE(nothing_matched({cpu, blank, blank, road, config}));
  // horizontal stripes have contrast, but none along the rows
  Image<std::uint8_t> stripes{width, height};
  for (int v{0}; v < height; ++v) std::fill(stripes.row(v), stripes.row(v) + width, v % 6 < 3 ? 40 : 160);
  EXPECT_TRUE(nothing_matched({cpu, stripes, stripes, road, config}));
  // the threshold is the window's mean of |L(u+1) − L(u−1)|, here 8 everywhere but at the ends
  Image<std::uint8_t> slope{width, height};
  for (const auto [u, v] : raster(width, height)) slope(u, v) = static_cast<std::uint8_t>((u * 4) % 256);
  const Image<std::uint8_t> ramp{[&] {
    Image<std::uint8_t> part{60, 20};
    for (int v{0}; v < 20; ++v) std::copy(slope.row(v), slope.row(v) + 60, part.row(v));
    return part;
  }()};
  config.texture = 7.99;
  EXPECT_EQ(MatchRun(cpu, ramp, ramp, no_road, config).space.textured.row(10)[30], 1);
  config.texture = 8.01;
  EXPECT_EQ(MatchRun(cpu, ramp, ramp, no_road, config).space.textured.row(10)[30], 0);
}

// Noise that has nothing to do with each other: the cheapest place of each pixel costs less by chance.
TEST(Matching, WhatCostsAsMuchAsChanceIsNoMatch) {
  Cpu cpu{2};
  std::mt19937 generator{11};
  Image<std::uint8_t> left{160, 60};
  Image<std::uint8_t> right{160, 60};
  for (Image<std::uint8_t>* image : {&left, &right}) {
    for (std::uint8_t& pixel : *image) pixel = static_cast<std::uint8_t>(generator() % 256);
  }
  const auto matched = [&](const MatchingConfig& config) {
    const MatchRun run{cpu, left, right, no_road, config};
    return std::ranges::count_if(run.matches.obstacle, [](float disparity) { return disparity > 0; });
  };
  MatchingConfig config{permissive_config()};
  const auto by_chance = matched(config);
  EXPECT_GT(by_chance, 2000);
  config.cost_limit = MatchingConfig{}.cost_limit;
  EXPECT_LT(matched(config), by_chance / 5);
}

TEST(Matching, FindsTheRoad) {
  const Texture texture{5};
  Cpu cpu{2};
  const MatchRun run{cpu, left_image(texture), right_image(texture, road_of_row), road, permissive_config()};
  const auto places{raster(40, width - 10, 20, height - 4)};
  int labelled{0};
  for (const auto [u, v] : places) {
    EXPECT_EQ(run.matches.obstacle(u, v) > 0 && run.matches.road(u, v) > 0, false);
    if (run.matches.road(u, v) == 0) continue;
    ++labelled;
    ASSERT_NEAR(run.matches.road(u, v), road_of_row(v), 0.2) << u << " " << v;
  }
  EXPECT_GT(labelled, 0.97 * static_cast<double>(places.size()));
}

// The plane of the frame before is a little off: the residual shift and its fraction make up for it.
TEST(Matching, FindsARoadThatIsNotWhereThePlaneSays) {
  const Texture texture{6};
  Cpu cpu{2};
  for (const double error_px : {-2.4, 0.7, 1.5}) {
    RoadPlane expected{road};
    expected.at_centre += error_px;
    const MatchRun run{cpu, left_image(texture), right_image(texture, road_of_row), expected, permissive_config()};
    const auto places{raster(40, width - 10, 30, height - 4)};
    double sum{0};
    int labelled{0};
    for (const auto [u, v] : places) {
      if (run.matches.road(u, v) == 0) continue;
      sum += run.matches.road(u, v) - road_of_row(v);
      ++labelled;
    }
    EXPECT_GT(labelled, 0.9 * static_cast<double>(places.size())) << error_px;
    EXPECT_NEAR(sum / labelled, 0, 0.1) << error_px;
  }
}

TEST(Matching, FindsARollingRoad) {
  const Texture texture{7};
  Cpu cpu{2};
  const RoadPlane rolled{12, 0.05, 0.2, width / 2.0, height / 2.0};
  // left u of right column w: w = u − d(u, v), which is linear in u
  const Image<std::uint8_t> right{textured_image(
      texture, width, height, [&](int w, int v) { return (w + rolled.disparity(0, v)) / (1 - rolled.per_u); })};
  const MatchRun run{cpu, left_image(texture), right, rolled, permissive_config()};
  const auto places{raster(40, width - 20, 12, height - 4)};
  int labelled{0};
  for (const auto [u, v] : places) {
    if (run.matches.road(u, v) == 0) continue;
    ++labelled;
    ASSERT_NEAR(run.matches.road(u, v), rolled.disparity(u, v), 0.3) << u << " " << v;
  }
  EXPECT_GT(labelled, 0.95 * static_cast<double>(places.size()));
}

TEST(Matching, AnUprightSurfaceIsAnObstacle) {
  const Texture texture{8};
  Cpu cpu{2};
  constexpr int shift{18};
  const MatchRun run{cpu, left_image(texture), right_image(texture, [](int) { return shift; }), road,
                     permissive_config()};
  const auto places{raster(40, width - 10, 10, height - 10)};
  int labelled{0};
  for (const auto [u, v] : places) {
    if (run.matches.obstacle(u, v) == 0) continue;
    ++labelled;
    ASSERT_NEAR(run.matches.obstacle(u, v), shift, 0.2) << u << " " << v;
  }
  EXPECT_GT(labelled, 0.97 * static_cast<double>(places.size()));
}

// A box stands on the road: upright down to its foot, road below and beside.
TEST(Matching, BoxOnTheRoadIsTheObstacle) {
  const Texture of_road{9};
  const Texture of_box{10};
  Cpu cpu{2};
  constexpr int foot{50};
  const double shift{road_of_row(foot)};
  const auto on_box = [&](double u, int v) { return u >= 60 && u < 110 && v >= 10 && v < foot; };
  Image<std::uint8_t> left{left_image(of_road)};
  Image<std::uint8_t> right{right_image(of_road, road_of_row)};
  for (const auto [u, v] : raster(width, height)) {
    if (on_box(u, v)) left(u, v) = static_cast<std::uint8_t>(of_box.at(u, v));
    if (on_box(u + shift, v)) right(u, v) = static_cast<std::uint8_t>(of_box.at(u + shift, v));
  }
  const MatchRun run{cpu, left, right, road, permissive_config()};
  int obstacle{0};
  int missed{0};
  for (const auto [u, v] : raster(68, 102, 16, foot - 8)) {
    obstacle += std::abs(run.matches.obstacle(u, v) - shift) < 0.5 ? 1 : 0;
    missed += run.matches.road(u, v) > 0 ? 1 : 0;
  }
  EXPECT_GT(obstacle, 0.95 * (foot - 24) * 34);
  EXPECT_LT(missed, 0.02 * (foot - 24) * 34);
  int false_obstacle{0};
  for (const auto [u, v] : raster(40, width - 10, foot + 8, height - 4))
    false_obstacle += run.matches.obstacle(u, v) > 0 ? 1 : 0;
  EXPECT_LT(false_obstacle, 0.02 * (height - foot - 12) * 110);
  int found_road{0};
  for (const auto [u, v] : raster(40, width - 10, foot + 8, height - 4))
    found_road += std::abs(run.matches.road(u, v) - road_of_row(v)) < 0.5 ? 1 : 0;
  EXPECT_GT(found_road, 0.9 * (height - foot - 12) * (width - 50));
}

}  // namespace
}  // namespace stereogrid::test
