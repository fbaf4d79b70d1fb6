// SPDX-License-Identifier: Apache-2.0
//
// Trenches in disparities as a car's camera and a matcher with windows of nine rows see them (docs/terrain.md,
// trenches).
#include "terrain/trenches.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

/// Camera 1 m above level ground, f = 425 px, f·B = 85 px·m, 40 sectors.
class Trenches : public testing::Test {
 protected:
  static constexpr int window{9};
  static constexpr int horizon{180};
  static constexpr int rows{360};
  static constexpr int sectors{40};
  static constexpr int middle{20};
  static constexpr int edge{250};  ///< row of the edge, 6.1 m ahead; 9 rows of wall are 0.9 m of trench

  /// Level ground, above `edge` a far wall of `wall_rows`, whose disparity grows by `growth` of the ground's per row.
  [[nodiscard]] float exact(int row, int wall_rows, float growth) const {
    const bool is_wall{row <= edge && row > edge - wall_rows};
    const auto at = static_cast<float>(is_wall ? edge - wall_rows : row);
    const float above_top{is_wall ? growth * static_cast<float>(row - edge + wall_rows) : 0.0f};
    return camera_.level_growth(1) * (at + above_top - horizon);
  }
  [[nodiscard]] float smeared(int row, int wall_rows, float growth = 0) const {
    float sum{0};
    for (int i{-window / 2}; i <= window / 2; ++i) sum += exact(row + i, wall_rows, growth);
    return sum / window;
  }
  using Disparity = std::function<float(int sector, int row)>;
  std::optional<Trench> found(const Disparity& disparity) {
    read(disparity);
    filter_.find(middle);
    return std::as_const(filter_).at(middle);
  }
  void read(const Disparity& disparity) {
    Image<float> road{sectors * sector_px, rows};
    const Image<float> obstacle{road.width(), rows};
    for (const auto [u, v] : raster(0, road.width(), horizon + 5, rows)) road(u, v) = disparity(u / sector_px, v);
    find_medians(obstacle.view(), road.view(), 0, sectors, 0, medians_.view());
    filter_.begin(SampledGround{camera_, limits_, road.width(), rows}, std::as_const(medians_).view());
  }
  /// Sectors with a trench, after connecting them.
  int connected(const Disparity& disparity) {
    read(disparity);
    filter_.find_all([](int count, const auto& work) { work(0, count); });
    filter_.connect();
    int count{0};
    for (int sector{0}; sector < sectors; ++sector) count += std::as_const(filter_).at(sector) ? 1 : 0;
    return count;
  }
  std::optional<Trench> found_wall(int wall_rows, float growth = 0) {
    return found([=, this](int, int row) { return smeared(row, wall_rows, growth); });
  }

  TerrainCamera camera_{{sectors * sector_px, rows, 425, sectors* sector_px / 2, horizon, 0.2, 1.0, 0, 0}, [] {
                          Ground ground;
                          ground.height_m = 1;
                          return ground;
                        }()};
  TerrainLimits limits_{0.15f, 0.364f, 1.8f, 0.25f, 0.105f};
  Image<float> medians_{rows, sectors};
  TrenchFilter filter_{rows, sectors, window};
};

TEST_F(Trenches, AreMeasuredByTheFarWall) {
  for (const int wall_rows : {6, 8, 9, 12, 20}) {
    const auto trench{found_wall(wall_rows)};
    ASSERT_TRUE(trench) << wall_rows;
    const float wall_x{425 / static_cast<float>(edge - wall_rows - horizon)};
    EXPECT_NEAR(trench->edge_x, 425.0f / (edge - horizon), 0.15) << "a row is 9 cm";
    EXPECT_NEAR(trench->wall_x, wall_x, 0.2);
    EXPECT_NEAR(trench->fall_m, wall_x * static_cast<float>(wall_rows) / 425, 0.04);
  }
}

TEST_F(Trenches, AreNotInGroundStepsAndHollows) {
  EXPECT_FALSE(found_wall(0));
  EXPECT_FALSE(found_wall(2));
  // everything above the edge is farther, as behind a kerb, or nearer, as a step up
  for (const float jump : {-1.2f, 1.2f}) {
    EXPECT_FALSE(found([=, this](int, int row) { return smeared(row, 0) + (row <= edge ? jump : 0); })) << jump;
  }
  const auto hollow = [this](int, int row) {
    return smeared(row, 0) - 0.6f * std::max(0.0f, 1 - std::abs(static_cast<float>(row - edge)) / 14);
  };
  EXPECT_FALSE(found(hollow));
}

TEST_F(Trenches, HaveUprightWalls) {
  EXPECT_TRUE(found_wall(9, 0.2f));
  EXPECT_FALSE(found_wall(9, 0.5f)) << "a slope down and up";
  EXPECT_TRUE(found_wall(9, -0.5f));
  EXPECT_FALSE(found_wall(4, -5)) << "falls too far for a wall";
}

// The trench is 0.9 m wide; two standard deviations of the range are 0.26 m.
TEST_F(Trenches, AreWideEnoughForAWheelToFallByAStep) {
  limits_.step_m = 0.3f;
  EXPECT_TRUE(found_wall(9)) << "from 1.04 m on";
  limits_.step_m = 0.4f;
  EXPECT_FALSE(found_wall(9)) << "from 1.39 m on";
}

TEST_F(Trenches, LieInGroundThatGrowsOnBothSides) {
  const auto wall = [this](int, int row) {
    return smeared(row, 9) + 0.8f * camera_.level_growth(1) * static_cast<float>(edge - row);
  };
  EXPECT_FALSE(found(wall));
}

TEST_F(Trenches, AreSeenThroughLittleNoiseOnly) {
  const auto noisy = [this](float px) {
    return found([=, this](int, int row) { return smeared(row, 9) + (row % 2 == 0 ? px : -px); });
  };
  EXPECT_TRUE(noisy(0.08f));
  EXPECT_FALSE(noisy(0.14f));
  EXPECT_FALSE(found([this](int, int row) { return smeared(row, 4) + (row % 2 == 0 ? 0.09f : -0.09f); }))
      << "too small for that noise";
}

TEST_F(Trenches, AreMeansOfMostSectorsAndRows) {
  EXPECT_TRUE(found([this](int sector, int row) { return sector <= middle ? smeared(row, 9) : 0; }));
  EXPECT_FALSE(found([this](int sector, int row) { return sector < middle ? smeared(row, 9) : 0; }));
  const auto without = [this](int share) {
    return found([=, this](int, int row) { return row % share != 1 ? smeared(row, 9) : 0; });
  };
  EXPECT_TRUE(without(6));
  EXPECT_FALSE(without(3));
}

TEST_F(Trenches, AreEdgesWithGroundLowerByMoreThanAStep) {
  const auto lower = [this](float jump) {
    return found([=, this](int, int row) {
      const float share{std::clamp(0.5f + static_cast<float>(edge - row) / window, 0.0f, 1.0f)};
      return smeared(row, 0) - jump * share;
    });
  };
  // d = 14 px, so a step of 0.15 m is 1.83 px
  EXPECT_FALSE(lower(1.7f));
  const auto edge_found{lower(2.3f)};
  ASSERT_TRUE(edge_found);
  EXPECT_NEAR(edge_found->edge_x, 6.07, 0.15);
  EXPECT_NEAR(edge_found->fall_m, 2.3 / (14 - 2.3), 0.02);
  limits_.drop_slope = 0.14f;
  EXPECT_FALSE(lower(2.3f)) << "the line of sight falls by less than 1.3 times that";
}

TEST_F(Trenches, ContinueBesideLongChains) {
  // noise of 0.14 px is too large for a trench alone
  const auto noisy_from = [this](int first) {
    return connected([=, this](int sector, int row) {
      return smeared(row, 9) + (sector < first ? 0.0f : row % 2 == 0 ? 0.14f : -0.14f);
    });
  };
  EXPECT_EQ(noisy_from(26), sectors);
  EXPECT_LT(noisy_from(10), 17);
}

TEST_F(Trenches, AreSearchedUpToTheDropSlope) {
  limits_.drop_slope = 0.17f;
  EXPECT_FALSE(found_wall(9)) << "the line of sight falls by 0.165";
  limits_.drop_slope = 0.16f;
  EXPECT_TRUE(found_wall(9));
}

// Noise hides the trench from the sectors that are searched first.
TEST_F(Trenches, DoNotDependOnTheFrameBefore) {
  constexpr int between{19};
  const auto in_order = [](int count, const auto& work) { work(0, count); };
  read([this](int, int row) { return smeared(row, 9); });
  filter_.find_all(in_order);
  EXPECT_TRUE(std::as_const(filter_).at(between));
  read([this](int sector, int row) {
    const bool is_noisy{std::abs(sector - between) > 3};
    return smeared(row, 9) + (!is_noisy ? 0.0f : row % 2 == 0 ? 0.98f : -0.98f);
  });
  filter_.find(between);
  EXPECT_TRUE(std::as_const(filter_).at(between));
  filter_.find_all(in_order);
  EXPECT_FALSE(std::as_const(filter_).at(between));
}

// The sanitizers find a row that is read beyond the image: the last sector is the end of the memory.
TEST_F(Trenches, AreFoundInTheLowestRowsWithTheSmallestWindow) {
  constexpr int smallest_window{3};
  constexpr int lowest_edge{rows - 1 - (smallest_window + 1)};
  filter_ = TrenchFilter{rows, sectors, smallest_window};
  read([this](int, int row) {
    const float share{std::clamp((lowest_edge + 1.5f - static_cast<float>(row)) / smallest_window, 0.0f, 1.0f)};
    return exact(row, 0, 0) - 6 * share;
  });
  filter_.find(sectors - 1);
  const auto& trench{std::as_const(filter_).at(sectors - 1)};
  ASSERT_TRUE(trench);
  EXPECT_NEAR(trench->row, lowest_edge, 1);
}

}  // namespace
}  // namespace stereogrid::test
