// SPDX-License-Identifier: Apache-2.0
#include "fusion/fusion.hpp"

#include <cmath>

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "fusion/model.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr GridGeometry one_cell{0, 0, 1, 1, 1};

ObservedGrid saying(float p, std::optional<float> confidence = {}) {
  return {one_cell, Image<float>{1, 1, p}, confidence ? Image<float>{1, 1, *confidence} : Image<float>{}};
}

Image<float> fused(const Image<float>& stereo, const GridInVehicle& grid, const std::vector<ObservedGrid>& others,
                   const FusionConfig& config) {
  Reference reference;
  Image<float> cells{stereo};
  fuse(reference, others, grid, config, cells.view());
  return cells;
}

float fused_cell(float stereo, const std::vector<ObservedGrid>& others, const FusionConfig& config) {
  return fused(Image<float>{1, 1, stereo}, {one_cell}, others, config)(0, 0);
}

constexpr FusionConfig independent{1};

TEST(Fusion, IndependentSourcesMultiplyTheirOdds) {
  // odds 4 · 4 = 16, 4 · 1/9, and 3 · 3 · 3 = 27
  EXPECT_NEAR(fused_cell(0.8f, {saying(0.8f)}, independent), 16.0 / 17, 1e-6);
  EXPECT_NEAR(fused_cell(0.8f, {saying(0.1f)}, independent), 4.0 / 13, 1e-6);
  EXPECT_NEAR(fused_cell(0.75f, {saying(0.75f), saying(0.75f)}, independent), 27.0 / 28, 1e-6);
}

TEST(Fusion, ConfidenceMovesAnIndependentSourceTowardsUnknown) {
  // with weight 0.5, 0.9 counts as 0.7
  const float expected{fused_cell(0.6f, {saying(0.7f)}, independent)};
  EXPECT_NEAR(fused_cell(0.6f, {saying(0.9f, 0.5f)}, independent), expected, 1e-6);
  EXPECT_NEAR(fused_cell(0.9f, {saying(0.6f)}, {0.5}), expected, 1e-6);
}

TEST(Fusion, WhatASourceDoesNotKnowLeavesTheOtherUnchanged) {
  for (const float p : {0.0007f, 0.1f, 0.5f, 0.731f, 0.98f}) {
    EXPECT_EQ(fused_cell(p, {saying(0.5f)}, independent), p);
    EXPECT_EQ(fused_cell(p, {saying(0.9f, 0.0f)}, independent), p);
    EXPECT_EQ(fused_cell(p, {}, independent), p);
  }
  EXPECT_EQ(fused_cell(0.5f, {saying(0.9f)}, independent), 0.9f);
  EXPECT_EQ(fused_cell(0.5f, {saying(0.5f)}, independent), 0.5f);
  EXPECT_EQ(fused_cell(0.1f, {saying(0.9f)}, {0}), 0.9f);
  EXPECT_EQ(fused_cell(0.1f, {saying(0.9f, 0.0f)}, {0}), 0.5f);
}

TEST(Fusion, TheOrderOfTheSourcesDoesNotMatter) {
  const float one_way{fused_cell(0.3f, {saying(0.9f), saying(0.2f, 0.4f), saying(0.6f)}, independent)};
  const float other_way{fused_cell(0.3f, {saying(0.6f), saying(0.9f), saying(0.2f, 0.4f)}, independent)};
  EXPECT_FLOAT_EQ(one_way, other_way);
}

TEST(Fusion, CertaintyOfAnotherSourceIsNotTheLastWord) {
  for (const float p : {0.0f, 1.0f}) {
    const float cell{fused_cell(0.5f, {saying(p)}, independent)};
    EXPECT_GT(cell, 0.0005f);
    EXPECT_LT(cell, 0.9995f);
    EXPECT_NEAR(fused_cell(0.5f, {saying(p), saying(1 - p)}, independent), 0.5, 1e-6);
  }
}

// Stereo never says free so surely that a wall would stay free which the lidar has surely seen; nor is what stereo has
// seen free because the lidar's rays pass over it. The lidar's grid (evaluation::LidarModelParameters) goes from 0.12,
// passed by a ray, to 0.993, hit by many.
TEST(Fusion, ByDefaultWhatOneSourceHasSeenIsNotFree) {
  for (const char* name : {"default", "paper"}) {
    const FusionConfig config{preset(name).fusion};
    for (const float free : {0.0f, 0.001f, 0.02f}) EXPECT_GT(fused_cell(free, {saying(0.993f)}, config), 0.75f) << free;
    EXPECT_GT(fused_cell(0.1f, {saying(0.993f)}, config), 0.9f);
    EXPECT_GT(fused_cell(0.98f, {saying(0.12f)}, config), 0.7f);
    EXPECT_GT(fused_cell(0.999f, {saying(0.12f)}, config), 0.8f);
  }
}

TEST(Fusion, OfAnotherGridTheCellCountsThatHoldsTheCentre) {
  // 4 × 3 cells of 1 m; the other one's 2 × 1 cells of 2 m begin at (1, 0.8): they hold the centres of the second to
  // fourth columns' two upper rows
  const GridGeometry geometry{0, 0, 1, 4, 3};
  ObservedGrid other{{1, 0.8, 2, 2, 1}, Image<float>{2, 1, 0.9f}, {}};
  other.occupancy(1, 0) = 0.2f;
  const Image<float> cells{fused(Image<float>{4, 3, 0.5f}, {geometry}, {other}, independent)};
  for (const auto [ix, iy] : raster(4, 3)) {
    const float expected{iy < 1 || ix < 1 ? 0.5f : (ix < 3 ? 0.9f : 0.2f)};
    EXPECT_EQ(cells(ix, iy), expected) << ix << ", " << iy;
  }
}

TEST(Fusion, CellsOfATurnedGridAreFoundInTheVehicleFrame) {
  // the grid's x axis is the vehicle's y: its cell (2, 0) has its centre at (−0.5, 2.5) + (10, 0)
  const GridInVehicle turned{{0, 0, 1, 4, 1}, 10, 0, 0, 1};
  const ObservedGrid other{{9, 2, 1, 1, 1}, Image<float>{1, 1, 0.9f}, {}};
  const Image<float> cells{fused(Image<float>{4, 1, 0.5f}, turned, {other}, independent)};
  for (int ix{0}; ix < 4; ++ix) EXPECT_EQ(cells(ix, 0), ix == 2 ? 0.9f : 0.5f) << ix;
}

TEST(Fusion, TheThreadedFormEqualsTheReference) {
  std::mt19937 generator{7};
  const auto random_image = [&](int width, int height) {
    Image<float> image{width, height};
    for (float& p : image) p = static_cast<float>(uniform(generator, 0, 1));
    return image;
  };
  const Image<float> stereo{random_image(83, 71)};
  const std::vector<ObservedGrid> others{{{-3, -5, 0.3, 40, 50}, random_image(40, 50), random_image(40, 50)},
                                         {{2, 1, 0.11, 61, 33}, random_image(61, 33), {}}};
  const GridInVehicle grid{{-4, -8, 0.2, 83, 71}, 1, -2, std::cos(0.3), std::sin(0.3)};
  const FusionConfig config{0.9};
  const Image<float> expected{fused(stereo, grid, others, config)};
  EXPECT_GT(count_differences(expected, stereo), 1000);
  for (const int threads : {1, 3}) {
    Cpu cpu{threads};
    Image<float> cells{stereo};
    fuse(cpu, others, grid, config, cells.view());
    EXPECT_EQ(count_differences(cells, expected), 0) << threads;
  }
}

constexpr Rig small_rig{160, 90, 80, 80, 45, 0.5, 1.5, 0, 0};

/// A pair of grey images in which nothing matches.
StereoFrame grey_frame() {
  StereoFrame frame;
  frame.name = "a";
  frame.left = frame.right = Image<std::uint8_t>{small_rig.width_px, small_rig.height_px, 100};
  return frame;
}

TEST(Fusion, ThePipelineHandsOnWhatAnotherSourceHasSeen) {
  for (const BackEnd back_end : {BackEnd::cpu, BackEnd::reference}) {
    Config config{preset("default")};
    config.filter.speeds_mps = {1.25};
    Pipeline pipeline{config, small_rig, {.back_end = back_end, .threads = 1}};
    StereoFrame frame{grey_frame()};
    frame.world_from_vehicle = Pose2{3, 4, 0.5};
    frame.other_grids.push_back({{4, 1, 1, 2, 2}, Image<float>{2, 2, 0.9f}, {}});
    const FrameResult& result{pipeline.process(frame)};
    const auto at = [&](const Image<float>& cells, double x, double y) {
      const GridGeometry& g{result.vehicle.geometry};
      return cells(static_cast<int>((x - g.x_min_m) / g.cell_size_m),
                   static_cast<int>((y - g.y_min_m) / g.cell_size_m));
    };
    EXPECT_NEAR(at(result.observed, 5.1, 2.1), 0.9, 1e-3);
    EXPECT_NEAR(at(result.observed, 5.1, -2.1), 0.5, 1e-3);
    EXPECT_GT(at(result.vehicle.occupancy, 5.1, 2.1), 0.6f);
    EXPECT_LT(at(result.vehicle.occupancy, 5.1, -2.1), 0.55f);
    EXPECT_EQ(at(result.vehicle.age_s, 5.1, 2.1), 0);
  }
}

// The least height is in the image from 2.3 m ahead on. What a camera cannot see nearer, another source can.
TEST(Fusion, AnotherSourceFreesWhatTheCameraOverlooks) {
  Pipeline pipeline{preset("default"), small_rig, {.threads = 1}};
  StereoFrame frame{grey_frame()};
  frame.world_from_vehicle = Pose2{};
  const auto after = [&](float observed, int frames) {
    frame.other_grids = {{{1, -0.5, 1, 1, 1}, Image<float>{1, 1, observed}, {}}};
    float occupancy{};
    for (int i{0}; i < frames; ++i) {
      frame.stamp_ns += 100'000'000;
      const FrameResult& result{pipeline.process(frame)};
      const CellIndex cell{*result.vehicle.geometry.cell_at({1.5, 0.1})};
      occupancy = result.vehicle.occupancy(cell.ix, cell.iy);
    }
    return occupancy;
  };
  EXPECT_GT(after(0.95f, 5), 0.9f);
  EXPECT_LT(after(0.05f, 2), 0.5f);
}

// Errors of several cameras are not independent: their mean log odds.
TEST(Fusion, CamerasThatSeeACellAreNotCountedTwice) {
  const auto fused = [](std::vector<float> seen) {
    std::vector<Image<float>> images;
    std::vector<View<const float>> cameras;
    for (const float p : seen) images.emplace_back(1, 1, p);
    for (const Image<float>& image : images) cameras.push_back(image.view());
    Image<float> cells{1, 1};
    fuse_camera_rows(cameras, 0, 1, cells.view());
    return cells(0, 0);
  };
  EXPECT_EQ(fused({0.5f, 0.5f}), 0.5f);
  EXPECT_EQ(fused({0.5f, 0.83f}), 0.83f) << "one camera";
  EXPECT_NEAR(fused({0.8f, 0.8f}), 0.8, 1e-6);
  EXPECT_NEAR(fused({0.8f, 0.2f, 0.5f}), 0.5, 1e-6);
  EXPECT_NEAR(fused({0.9f, 0.5f + 1e-6f}), 0.75, 1e-4) << "odds 9 and 1: 3";
  EXPECT_NEAR(fused({0.8f, 0.8f, 0.5f, 0.2f}), 0.6135, 1e-4) << "odds 4, 4 and 1/4: the third root of 4";
  EXPECT_NEAR(fused({1.0f, 0.0f}), 0.5, 1e-6) << "certain cameras";
}

TEST(Fusion, RootsBySquareRoots) {
  for (int n{1}; n <= cameras_max; ++n) {
    for (const double odds : {1e-24, 0.001, 0.7, 1.0, 2.0, 999.0, 1e24})
      EXPECT_NEAR(root(odds, n) / std::pow(odds, 1.0 / n), 1, 1e-14) << odds << " " << n;
  }
}

TEST(Fusion, ThePipelineRefusesGridsThatCannotBe) {
  Pipeline pipeline{preset("default"), small_rig, {.threads = 1}};
  const auto error_text = [&](const ObservedGrid& grid) {
    StereoFrame frame{grey_frame()};
    frame.other_grids = {saying(0.5f), grid};
    return test::error_text_of<InputError>([&] { pipeline.process(frame); });
  };
  constexpr float nan{std::numeric_limits<float>::quiet_NaN()};
  EXPECT_NE(error_text(saying(nan)).find("not probabilities"), std::string::npos);
  EXPECT_NE(error_text(saying(1.01f)).find("not probabilities"), std::string::npos);
  EXPECT_NE(error_text(saying(0.5f, -0.1f)).find("not probabilities"), std::string::npos);
  EXPECT_NE(error_text({one_cell, Image<float>{2, 1}, {}}).find("size"), std::string::npos);
  EXPECT_NE(error_text({one_cell, Image<float>{1, 1}, Image<float>{1, 2}}).find("size"), std::string::npos);
  EXPECT_NE(error_text({{0, 0, 0, 1, 1}, Image<float>{1, 1}, {}}).find("no place"), std::string::npos);
  EXPECT_EQ(error_text(saying(1.0f)), "");
}

constexpr float nan{std::numeric_limits<float>::quiet_NaN()};

TEST(Grid, CellsAndPlaces) {
  const GridGeometry grid{-1, 2, 0.5, 4, 3};
  EXPECT_DOUBLE_EQ(grid.centre(0, 0).x, -0.75);
  EXPECT_DOUBLE_EQ(grid.centre(3, 2).y, 3.25);
  for (const auto [ix, iy] : raster(grid.nx, grid.ny))
    EXPECT_EQ(grid.cell_at(grid.centre(ix, iy)), (CellIndex{ix, iy}));
  EXPECT_EQ(grid.cell_at({-1, 2}), (CellIndex{0, 0})) << "the lower edges belong to a cell";
  EXPECT_EQ(grid.cell_at({1, 2.1}), std::nullopt) << "the upper ones do not";
  EXPECT_EQ(grid.cell_at({0, 1.999}), std::nullopt);
  EXPECT_EQ(grid.cell_at({-1e300, 2}), std::nullopt);
  EXPECT_EQ(grid.cell_at({static_cast<double>(nan), 2}), std::nullopt);
}

TEST(Grid, WhatIsKnown) {
  for (const float p : {0.0f, 0.44f, 0.56f, 1.0f}) EXPECT_TRUE(is_known(p)) << p;
  for (const float p : {0.46f, 0.5f, 0.54f, nan}) EXPECT_FALSE(is_known(p)) << p;
}

TEST(OccupancyValues, OfEachScale) {
  using enum OccupancyScale;
  for (const auto& [scale, p, value] : std::vector<std::tuple<OccupancyScale, float, int>>{{percent, 0, 0},
                                                                                           {percent, 0.02f, 2},
                                                                                           {percent, 0.7f, 70},
                                                                                           {percent, 1, 100},
                                                                                           {percent, 0.5f, -1},
                                                                                           {percent, nan, -1},
                                                                                           {percent, 7, 100},
                                                                                           {trinary, 0.1f, 0},
                                                                                           {trinary, 0.4f, -1},
                                                                                           {trinary, 0.6f, -1},
                                                                                           {autoware, 0, 1},
                                                                                           {autoware, 1, 99},
                                                                                           {autoware, 0.7f, 70},
                                                                                           {autoware, 0.5f, 50},
                                                                                           {autoware, nan, 50},
                                                                                           {trinary, 0.66f, 100}}) {
    EXPECT_EQ(occupancy_value(p, scale), value) << static_cast<int>(scale) << " " << p;
  }
}

// Nav2's static layer takes 100 for an obstacle, 99 for "inscribed" and -1 for unknown.
TEST(OccupancyValues, Nav2) {
  const auto value = [](float p) { return int{occupancy_value(p, OccupancyScale::nav2)}; };
  EXPECT_EQ(value(0.1f), 0);
  EXPECT_EQ(value(0.7f), 100);
  EXPECT_EQ(value(0.5f), -1);
  int before{0};
  for (int i{0}; i <= 1000; ++i) {
    const float p{static_cast<float>(i) / 1000};
    if (!is_known(p)) continue;
    EXPECT_NE(value(p), 99) << p;
    EXPECT_GE(value(p), before) << p;
    before = value(p);
  }
  EXPECT_GT(value(0.36f), 0);
  EXPECT_LE(value(0.64f), 98);
}

TEST(OccupancyValues, RowsFollowEachOther) {
  Image<float> occupancy{3, 2, 0.5f};
  occupancy(2, 0) = 1;
  occupancy(0, 1) = 0;
  EXPECT_EQ(occupancy_values(occupancy.view(), OccupancyScale::percent),
            (std::vector<std::int8_t>{-1, -1, 100, 0, -1, -1}));
}

}  // namespace
}  // namespace stereogrid::test
