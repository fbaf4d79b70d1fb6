// SPDX-License-Identifier: Apache-2.0
#include "observation/rays/rays.hpp"

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "observation/rays/simd.hpp"
#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

constexpr int disparities{40};

// f·b = 100 px·m; the road lies at v = 50 + d·1.5/0.25 = 50 + 6·d.
Rig round_rig() {
  return {201, 200, 400, 100, 50, 0.25, 1.5, 0, 0};
}

Ground level_ground() {
  return {1.5, 0, 0, true};
}

constexpr GridGeometry grid{0, -5, 0.2, 100, 50};

/// Columns from u to end, at a disparity, all rows of 0 … height_m above the road.
void put_wall(int u, int end, float disparity, double height_m, Matches& matches) {
  const RowsByHeight rows{round_rig(), level_ground()};
  const int top{std::max(static_cast<int>(std::ceil(rows.row(disparity, height_m))), 0)};
  const int bottom{std::min(static_cast<int>(std::floor(rows.row(disparity, 0))), matches.road.height() - 1)};
  for (; u < end; ++u) {
    for (int v{top}; v <= bottom; ++v) {
      matches.obstacle(u, v) = disparity;
      matches.road(u, v) = 0;
    }
  }
}

Matches empty_road() {
  Matches matches{201, 200};
  for (const auto [u, v] : raster(0, 201, 60, 200)) matches.road(u, v) = static_cast<float>((v - 50) / 6.0);
  return matches;
}

Image<float> cells_of(const Matches& matches, const GridInVehicle& where = {grid}) {
  Cpu cpu{2};
  RayWorkspace space{matches.road.width(), matches.road.height(), disparities};
  count_rays(cpu, matches, round_rig(), level_ground(), UDisparityConfig{}, space);
  Image<float> cells{where.grid.nx, where.grid.ny, -7.0f};
  project_rays(cpu, space, BinGeometry{round_rig()}, where, cells.view());
  return cells;
}

float at(const Image<float>& cells, double x, double y) {
  return cells(static_cast<int>(std::floor((x - grid.x_min_m) / grid.cell_size_m)),
               static_cast<int>(std::floor((y - grid.y_min_m) / grid.cell_size_m)));
}

TEST(Rays, WhatNoRayReachesIsUnknown) {
  const Image<float> nothing{cells_of(Matches{201, 200})};
  EXPECT_EQ(std::count(nothing.begin(), nothing.end(), 0.5f), static_cast<std::ptrdiff_t>(nothing.size()));
  const Image<float> road{cells_of(empty_road())};
  EXPECT_EQ(at(road, 2.3, 0.1), 0.5f);    // nearer than the largest disparity
  EXPECT_EQ(at(road, 10.1, 3.5), 0.5f);   // beside the image
  EXPECT_EQ(at(road, 10.1, -3.5), 0.5f);  // on the other side
  Matches wall{empty_road()};
  put_wall(0, 201, 10, 10, wall);  // as high as the image
  const Image<float> behind{cells_of(wall)};
  EXPECT_EQ(at(behind, 15.1, 0.1), 0.5f);
  EXPECT_EQ(at(behind, 19.1, 1.1), 0.5f);
}

TEST(Rays, ARoadIsFreeAndAWallOccupied) {
  const Image<float> road{cells_of(empty_road())};
  for (double x{3.1}; x < 15; x += 0.2) EXPECT_LT(at(road, x, 0.1), 0.1f) << x;
  Matches matches{empty_road()};
  put_wall(80, 121, 10, 1.5, matches);  // 10 m ahead, y ±0.5
  const Image<float> cells{cells_of(matches)};
  EXPECT_GT(std::max(at(cells, 9.9, 0.1), at(cells, 10.1, 0.1)), 0.95f);
  EXPECT_LT(at(cells, 8.1, 0.1), 0.05f);  // in front of it
  EXPECT_LT(at(cells, 10.1, 1.9), 0.2f);  // beside it
  EXPECT_LT(at(cells, 10.1, -1.9), 0.2f);
}

// The paper's example: the upper half of a person is visible above a low wall.
TEST(Rays, APersonHalfHiddenIsFound) {
  Matches matches{empty_road()};
  put_wall(92, 109, 8, 1.75, matches);  // 12.5 m ahead
  put_wall(60, 141, 16, 0.8, matches);  // 6.25 m ahead
  const Image<float> cells{cells_of(matches)};
  EXPECT_GT(std::max(at(cells, 12.3, 0.1), at(cells, 12.5, 0.1)), 0.9f);
  EXPECT_GT(at(cells, 6.3, 0.1), 0.9f);
  EXPECT_LT(at(cells, 9.5, 0.1), 0.5f);  // seen through, between them
}

// A carton 10 m ahead whose pattern repeats: rays pass over it to a wall, and without its ambiguous pixels through it.
TEST(Rays, NothingIsSeenThroughARepeatingPattern) {
  Matches matches{empty_road()};
  put_wall(60, 141, 4, 3, matches);
  const auto cells_with = [&](float pixel) {
    put_wall(80, 121, 10, 1.2, matches);
    for (float& d : matches.obstacle) d = d == 10 ? pixel : d;
    return cells_of(matches);
  };
  EXPECT_LT(at(cells_with(0), 10.3, 0.1), 0.2f) << "nothing matched";
  const Image<float> cells{cells_with(ambiguous_px)};
  for (const double x : {10.1, 10.3, 12.1, 18.1}) EXPECT_GE(at(cells, x, 0.1), 0.5f) << x;
  EXPECT_LT(at(cells, 8.1, 0.1), 0.1f) << "in front of it";
  EXPECT_LT(at(cells, 12.1, 1.9), 0.2f) << "beside it";
}

TEST(Rays, LeftOfTheImageIsLeftOfTheCar) {
  Matches matches{empty_road()};
  put_wall(40, 60, 10, 1.5, matches);  // y = (100 − 50)·0.25/10 = 1.25 m
  const Image<float> cells{cells_of(matches)};
  EXPECT_GT(std::max(at(cells, 9.9, 1.3), at(cells, 10.1, 1.3)), 0.9f);
  EXPECT_LT(at(cells, 10.1, -1.3), 0.3f);
}

TEST(Rays, RollTurnsTheRows) {
  Matches matches{201, 200};
  const Ground rolled{1.5, 0, 0.1, true};
  const Ground level{level_ground()};
  const RowsByHeight rows{round_rig(), rolled};
  for (int u{0}; u < 201; ++u) {  // pixels 0.1 m above a road that is rolled
    const double v{rows.row(10, 0.1) - std::tan(0.1) * (u - 100)};
    matches.obstacle(u, static_cast<int>(std::lround(v))) = 10;
  }
  RayWorkspace space{201, 200, disparities};
  Reference reference;
  const auto ending = [&](const Ground& ground) {
    count_rays(reference, matches, round_rig(), ground, UDisparityConfig{}, space);
    return count_of(space.sums(space.bins, 201), ending_ray);
  };
  EXPECT_EQ(ending(rolled), 0);
  EXPECT_GT(ending(level), 40);
}

// With a camera above the obstacles, a row near the horizon is possible for far bins only.
TEST(Rays, RowsEndWhereACameraHigherThanObstaclesLooksOverThem) {
  Rig rig{round_rig()};
  rig.camera_height_m = 3;
  const RowsByHeight rows{rig, {3, 0, 0, true}};
  for (int row{-20}; row < 220; ++row) {
    const RayRow found{ray_row(rows, 1.8, row, disparities * ray_bins_per_px)};
    for (int bin{1}; bin < disparities * ray_bins_per_px; ++bin) {
      const double d{(bin + 0.5) / ray_bins_per_px};
      const bool is_possible{rows.row(d, 1.8) <= row && row <= rows.row(d, 0)};
      const bool is_near{std::abs(rows.row(d, 1.8) - row) < 6 || std::abs(rows.row(d, 0) - row) < 6};  // half a bin
      if (!is_near) {
        EXPECT_EQ(bin >= found.first && bin < found.end, is_possible) << row << " " << bin;
      }
    }
  }
}

TEST(Rays, NothingIsSurerThanAThousandToOne) {
  for (const float log_odds : {6.9f, 20.0f, 80.0f}) {
    EXPECT_NEAR(probability_of(log_odds), 0.999, 1e-5) << log_odds;
    EXPECT_NEAR(probability_of(-log_odds), 0.001, 1e-5) << log_odds;
  }
  EXPECT_NEAR(probability_of(6.0f), 1 / (1 + std::exp(-6.0)), 1e-6) << "below it, it is as sure as it says";
  EXPECT_NEAR(probability_of(-6.0f), 1 / (1 + std::exp(6.0)), 1e-6);
}

TEST(Rays, MathematicsAreNearTheRealOnes) {
  for (float x{1e-30f}; x < 1e30f; x *= 1.0173f) {
    EXPECT_NEAR(natural_log(x), std::log(x), 2e-6 * (1 + std::abs(std::log(x)))) << x;
    EXPECT_NEAR(inverse_root(x) * std::sqrt(x), 1, 1e-5) << x;
  }
  for (float x{-80}; x <= 80; x += 0.137f) EXPECT_NEAR(exponential(x) / std::exp(static_cast<double>(x)), 1, 4e-6) << x;
}

// Counts have 21 bits: cells across too many columns are unknown, not wrong.
TEST(Rays, MoreColumnsThanTheCountsHoldAreUnknown) {
  EXPECT_LT(static_cast<long>(columns_max(2160)) * 2160, 1L << ray_bits);
  Cpu cpu{1};
  RayWorkspace space{201, 200, disparities};
  count_rays(cpu, empty_road(), round_rig(), level_ground(), UDisparityConfig{}, space);
  const RaySums<Host> sums{std::as_const(space.sums).view()};
  const GridInVehicle one_cell{grid_in_vehicle({9.9, -0.1, 0.2, 1, 1}, {})};
  const auto at_10_m = [&](int most_columns) {  // 8 columns and 5 to either side
    return occupancy_at(sums, most_columns, CellsInView{BinGeometry{round_rig()}, one_cell, 0.5f}, 0, 0);
  };
  EXPECT_LT(at_10_m(18), 0.1f);
  EXPECT_EQ(at_10_m(17), 0.5f);
  for (const int most_columns : {17, 18}) {
    Image<float> cells{1, 1};
    project_ray_cells(sums, most_columns, {BinGeometry{round_rig()}, one_cell, 0.5f}, {0, 0, 1, 1}, cells.view());
    EXPECT_EQ(cells(0, 0), at_10_m(most_columns));
  }
}

// An upright surface with noise of uniform distribution.
Matches noisy_surface(float noise_px) {
  std::mt19937 generator{7};
  Matches matches{201, 200};
  for (float& d : matches.obstacle) d = 8 + static_cast<float>(uniform(generator, -noise_px, noise_px));
  return matches;
}

TEST(Blur, GrowsWithTheNoiseBetweenItsLimits) {
  constexpr int window_px{9};
  EXPECT_FLOAT_EQ(blur_of(noisy_surface(0), window_px), 0.35f);
  const float blur{blur_of(noisy_surface(0.2f), window_px)};
  EXPECT_GT(blur, blur_of(noisy_surface(0.16f), window_px));
  EXPECT_NEAR(blur, 3 * 0.2f / std::sqrt(3.0f), 0.1f) << "three standard deviations";
  EXPECT_FLOAT_EQ(blur_of(noisy_surface(0.6f), window_px), widest_blur_px);
  EXPECT_FLOAT_EQ(blur_of(empty_road(), window_px), widest_blur_px) << "too few obstacle pixels";
}

Matches random_matches(int width, int height, std::mt19937& generator) {
  Matches matches{width, height};
  for (std::size_t i{0}; i < matches.road.size(); ++i) {
    const double kind{uniform(generator, 0, 1)};
    const auto disparity{static_cast<float>(uniform(generator, 0.1, disparities + 3.0))};
    if (kind < 0.4) matches.obstacle.data()[i] = disparity;
    if (kind > 0.6) matches.road.data()[i] = disparity;
  }
  return matches;
}

TEST(RaysEquality, CpuEqualsReference) {
  std::mt19937 generator{71};
  Reference reference;
  for (int round{0}; round < 40; ++round) {
    const int width{uniform_int(generator, 1, 200)};
    const int height{uniform_int(generator, 1, 90)};
    Rig rig{width,
            height,
            uniform(generator, 40, 300),
            uniform(generator, -5, width + 5.0),
            uniform(generator, -20, 80),
            uniform(generator, 0.1, 0.6),
            uniform(generator, 0.3, 3),
            0,
            0};
    const Ground ground{rig.camera_height_m, uniform(generator, -0.1, 0.1), uniform(generator, -0.2, 0.2), true};
    Matches matches{random_matches(width, height, generator)};
    for (float& d : matches.obstacle) d = d == 0 && uniform(generator, 0, 1) < 0.7 ? ambiguous_px : d;
    UDisparityConfig config;
    config.follow_roll = round % 2 == 0;
    Cpu cpu{1 + round % 3};
    const bool has_relief{round % 3 == 0};
    RayWorkspace slow{width, height, disparities, has_relief};
    RayWorkspace fast{width, height, disparities, has_relief};
    Image<std::int16_t> relief{2 * disparities, relief_sectors(width)};
    const int most{round % 2 == 0 ? height : 0};
    for (std::int16_t& rows : relief) rows = static_cast<std::int16_t>(uniform_int(generator, -most, most));
    if (has_relief) slow.relief = fast.relief = {std::as_const(relief).view()};
    count_rays(reference, matches, rig, ground, config, slow);
    for (const std::int64_t target : vector_targets()) {
      const ForcedTarget forced{target};
      for (int frame{0}; frame < 2; ++frame) count_rays(cpu, matches, rig, ground, config, fast);
      ASSERT_EQ(slow.sums, fast.sums) << "round " << round << " " << name_of_target(target);
    }
    slow.blur_px = fast.blur_px = static_cast<float>(uniform(generator, 0, 0.6));
    const int columns{uniform_int(generator, 1, 150)};
    const GridInVehicle where{grid_in_vehicle({uniform(generator, -5, 5), -4, 0.3, columns, 27},
                                              {uniform(generator, -3, 6), 1, uniform(generator, -3.1, 3.1)})};
    Image<float> expected{columns, 27};
    project_rays(reference, slow, BinGeometry{rig}, where, expected.view());
    Image<float> cells;
    for (const std::int64_t target : vector_targets()) {
      const ForcedTarget forced{target};
      cells = Image<float>{columns, 27, -7.0f};
      project_rays(cpu, fast, BinGeometry{rig}, where, cells.view());
      EXPECT_EQ(count_differences(expected, cells), 0) << "round " << round << " " << name_of_target(target);
    }
    for (const float p : cells) ASSERT_TRUE(p >= 0.0009f && p <= 0.9991f) << p;
  }
}

// A scene that lies higher by a relief gives the cells that it gives without.
TEST(Rays, HeightsAreOverTheRelief) {
  constexpr std::int16_t raised{12};
  Matches level{empty_road()};
  put_wall(80, 120, 8, 1.2, level);
  Matches higher{201, 200};
  for (int v{0}; v + raised < 200; ++v) {
    std::copy_n(level.obstacle.row(v + raised), 201, higher.obstacle.row(v));
    std::copy_n(level.road.row(v + raised), 201, higher.road.row(v));
  }
  const Image<std::int16_t> relief{2 * disparities, relief_sectors(201), raised};
  Reference reference;
  RayWorkspace space{201, 200, disparities, true};
  space.relief = {relief.view()};
  count_rays(reference, higher, round_rig(), level_ground(), UDisparityConfig{}, space);
  Image<float> cells{grid.nx, grid.ny};
  project_rays(reference, space, BinGeometry{round_rig()}, {grid}, cells.view());
  const Image<float> expected{cells_of(level)};
  for (const auto [ix, iy] : raster(25, grid.nx, 0, grid.ny))
    EXPECT_EQ(cells(ix, iy), expected(ix, iy)) << ix << " " << iy;
}

// Counted by hand, pixel by pixel, without sums.
TEST(Rays, SumsAreThoseOfThePixels) {
  std::mt19937 generator{73};
  const Matches matches{random_matches(23, 31, generator)};
  const Rig rig{23, 31, 50, 11, 9, 0.3, 1.2, 0, 0};
  const Ground ground{1.2, 0.01, 0, true};
  RayWorkspace space{23, 31, disparities};
  Reference reference;
  count_rays(reference, matches, rig, ground, UDisparityConfig{}, space);
  const RowsByHeight rows{rig, ground};
  for (const int k : {7, 20, 61, 80}) {
    for (const int columns : {1, 9, 23}) {
      int ending{0};
      int road{0};
      for (const auto [u, v] : raster(columns, 31)) {
        const double d{matches.obstacle(u, v)};
        if (d > 0 && d < k / 2.0 && v <= rows.row(d, 0.25) && v >= rows.row(d, 1.8)) ++ending;
        if (matches.road(u, v) > 0 && matches.road(u, v) < static_cast<float>(k) / 2) ++road;
      }
      EXPECT_EQ(count_of(space.sums(k, columns), ending_ray), ending) << k << " " << columns;
      EXPECT_EQ(count_of(space.sums(k, columns), ending_on_road), road) << k << " " << columns;
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
