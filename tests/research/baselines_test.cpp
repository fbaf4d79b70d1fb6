// SPDX-License-Identifier: Apache-2.0
#include "baselines/baselines.hpp"
#include "../evaluation/support.hpp"
#include "baselines/columns.hpp"

namespace stereogrid::research::testing {
namespace {

using evaluation::testing::around;
using evaluation::testing::half_metre_grid;
using evaluation::testing::values_of;

/// f·b = 100 px·m: a wall of disparity d stands at x = 100/d m. The camera has the pitch `pitch_rad`.
Rig hundred_rig() {
  return {.width_px = 241,
          .height_px = 161,
          .focal_px = 200,
          .cx_px = 120,
          .cy_px = 60,
          .baseline_m = 0.5,
          .camera_height_m = 1.5};
}

/// Exact disparity images of a flat road with upright walls on it.
class DisparityScene {
 public:
  explicit DisparityScene(double pitch_rad = 0) : rig_{hundred_rig()} {
    ground_.height_m = rig_.camera_height_m;
    ground_.pitch_rad = pitch_rad;
  }

  /// The road up to a distance.
  DisparityScene& road(double to_m = 100) {
    for (int v{0}; v < rig_.height_px; ++v) {
      const double d{road_disparity(v)};
      if (d < rig_.focal_px * rig_.baseline_m / to_m) continue;
      for (int u{0}; u < rig_.width_px; ++u) road_(u, v) = static_cast<float>(d);
    }
    return *this;
  }

  /// A wall on the columns first_u … last_u. Nearer walls have to come after farther ones.
  DisparityScene& wall(int first_u, int last_u, double at_m, double top_m, double bottom_m = 0) {
    const double d{rig_.focal_px * rig_.baseline_m / at_m};
    const int top{std::max(0, static_cast<int>(std::ceil(row_at(d, top_m))))};
    const int bottom{std::min(rig_.height_px - 1, static_cast<int>(std::floor(row_at(d, bottom_m))))};
    for (int v{top}; v <= bottom; ++v) {
      for (int u{first_u}; u <= last_u; ++u) {
        obstacle_(u, v) = static_cast<float>(d);
        road_(u, v) = 0;
      }
    }
    return *this;
  }

  [[nodiscard]] DisparityFrame frame() const { return {rig_, ground_, 48, obstacle_.view(), road_.view()}; }

 private:
  // d = (b cos θ / H)(v − v_hor), v_hor = v0 − f tan θ
  [[nodiscard]] double horizon() const { return rig_.cy_px - rig_.focal_px * std::tan(ground_.pitch_rad); }
  [[nodiscard]] double road_disparity(int v) const {
    return rig_.baseline_m * std::cos(ground_.pitch_rad) / ground_.height_m * (v - horizon());
  }
  [[nodiscard]] double row_at(double d, double height_m) const {
    return horizon() + d * (ground_.height_m - height_m) / (rig_.baseline_m * std::cos(ground_.pitch_rad));
  }

  Rig rig_;
  Ground ground_;
  Image<float> obstacle_{rig_.width_px, rig_.height_px};
  Image<float> road_{rig_.width_px, rig_.height_px};
};

using ::testing::Each, ::testing::ElementsAre, ::testing::Values;

struct Baseline {
  std::string name;
  std::function<Image<float>(const DisparityFrame&, const GridGeometry&)> grid_of;
  bool observes_behind;  ///< says something about cells behind the nearest obstacle
};

void PrintTo(const Baseline& baseline, std::ostream* out) {
  *out << baseline.name;
}

const Baseline nearest{"nearest", [](const auto& f, const auto& g) { return nearest_obstacle_grid(f, g); }, false};
const Baseline boundary{"boundary", [](const auto& f, const auto& g) { return occupancy_boundary_grid(f, g); }, false};
const Baseline free_space{"free_space", [](const auto& f, const auto& g) { return free_space_grid(f, g); }, false};
const Baseline layers{"stixels", [](const auto& f, const auto& g) { return stixel_grid(f, g); }, true};
const Baseline rays{"ray_casting", [](const auto& f, const auto& g) { return ray_casting_grid(f, g); }, true};

class EveryBaseline : public ::testing::TestWithParam<Baseline> {
 protected:
  static Image<float> grid_of(const DisparityScene& scene) {
    return GetParam().grid_of(scene.frame(), half_metre_grid);
  }
  static void expect_free(const Image<float>& cells, double x_m, double y_m) {
    EXPECT_LT(around(cells, half_metre_grid, x_m, y_m).largest, 0.45F) << x_m << " m ahead, " << y_m << " m left";
  }
  static void expect_unknown(const Image<float>& cells, double x_m, double y_m) {
    EXPECT_NEAR(around(cells, half_metre_grid, x_m, y_m).largest, 0.5F, 0.05F)
        << x_m << " m ahead, " << y_m << " m left";
    EXPECT_NEAR(around(cells, half_metre_grid, x_m, y_m).smallest, 0.5F, 0.05F)
        << x_m << " m ahead, " << y_m << " m left";
  }
  static void expect_occupied(const Image<float>& cells, double x_m, double y_m) {
    EXPECT_GT(around(cells, half_metre_grid, x_m, y_m).largest, 0.6F) << x_m << " m ahead, " << y_m << " m left";
  }
};

INSTANTIATE_TEST_SUITE_P(Baselines, EveryBaseline, Values(nearest, boundary, free_space, layers, rays),
                         [](const auto& test) { return test.param.name; });

TEST_P(EveryBaseline, FreeBeforeAWallOccupiedAtItUnknownBehind) {
  const Image<float> cells{grid_of(DisparityScene{}.road().wall(0, 240, 10, 2.5))};
  for (const double y_m : {-2.0, 0.0, 1.0}) {
    expect_free(cells, 6, y_m);
    expect_free(cells, 8, y_m);
    expect_occupied(cells, 10, y_m);
    expect_unknown(cells, 14, y_m);
    expect_unknown(cells, 20, y_m);
  }
}

TEST_P(EveryBaseline, FollowsTheGroundsPitch) {
  const Image<float> cells{grid_of(DisparityScene{0.03}.road().wall(0, 240, 10, 2.5))};
  expect_free(cells, 7, 0);
  expect_occupied(cells, 10, 0);
  expect_unknown(cells, 15, 0);
}

TEST_P(EveryBaseline, OpenRoadIsFree) {
  const Image<float> cells{grid_of(DisparityScene{}.road())};
  for (const double x_m : {4.0, 8.0, 16.0}) expect_free(cells, x_m, 0);
  for (const float p : cells) EXPECT_LE(p, 0.5F);
}

TEST_P(EveryBaseline, SeesThroughAGap) {
  // walls of 8 m distance to both sides, between them a wall at 16 m
  DisparityScene scene;
  scene.road().wall(0, 240, 16, 2.5).wall(0, 80, 8, 2.5).wall(160, 240, 8, 2.5);
  const Image<float> cells{grid_of(scene)};
  expect_occupied(cells, 8, 2.5);
  expect_occupied(cells, 8, -2.5);
  expect_free(cells, 8, 0);
  expect_free(cells, 12, 0);
  expect_occupied(cells, 16, 0);
  expect_unknown(cells, 12, 4);
}

TEST_P(EveryBaseline, ATallWallBehindALowOneIsSeenByThoseThatLookThere) {
  const Image<float> cells{grid_of(DisparityScene{}.road().wall(0, 240, 16, 2.5).wall(0, 240, 8, 0.9))};
  expect_occupied(cells, 8, 0);
  expect_free(cells, 6, 0);
  if (GetParam().observes_behind) {
    expect_occupied(cells, 16, 0);
  } else {
    expect_unknown(cells, 16, 0);
  }
}

TEST_P(EveryBaseline, WhatHangsAboveTheCarIsNoObstacle) {
  const Image<float> cells{grid_of(DisparityScene{}.road().wall(0, 240, 10, 3.5, 2.3))};
  expect_free(cells, 6, 0);
  EXPECT_LE(around(cells, half_metre_grid, 10, 0).largest, 0.5F);
}

TEST_P(EveryBaseline, NothingMatchedIsNothingKnown) {
  EXPECT_THAT(values_of(grid_of(DisparityScene{})), Each(0.5F));
}

TEST_P(EveryBaseline, TakesImagesAndGridsOfAnySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{7, 3}, std::pair{2, 90}, std::pair{33, 17}}) {
    Rig rig{hundred_rig()};
    rig.width_px = width;
    rig.height_px = height;
    rig.cx_px = width / 2.0;
    rig.cy_px = height / 2.0;
    const Image<float> full{width, height, 5.5F};
    const Image<float> none{width, height};
    const GridGeometry grid{-3, -1.3, 0.7, 13, 5};  // partly behind the camera
    for (const auto& [obstacle, road] : {std::pair{&full, &none}, std::pair{&none, &full}, std::pair{&full, &full}}) {
      const Image<float> cells{GetParam().grid_of({rig, {}, 9, obstacle->view(), road->view()}, grid)};
      ASSERT_EQ(cells.width(), 13);
      ASSERT_EQ(cells.height(), 5);
      for (const float p : cells) EXPECT_TRUE(p >= 0 && p <= 1) << p;
      for (int iy{0}; iy < 5; ++iy) EXPECT_EQ(cells(0, iy), 0.5F) << "behind the camera";
    }
  }
}

TEST(NearestObstacleGrid, DropsSpikes) {
  DisparityScene scene;
  scene.road().wall(0, 240, 16, 2.5).wall(118, 121, 6, 1.0);
  const auto at_spike = [&](int spike_px) {
    NearestObstacleParameters parameters;
    parameters.spike_px = spike_px;
    return around(nearest_obstacle_grid(scene.frame(), half_metre_grid, parameters), half_metre_grid, 6, 0).largest;
  };
  EXPECT_GT(at_spike(1), 0.6F);
  EXPECT_LT(at_spike(10000), 0.45F);
}

TEST(NearestObstacleGrid, WithoutAFilledHeightTheNearestPixelsDecide) {
  DisparityScene scene;
  scene.road().wall(0, 240, 16, 2.5).wall(0, 240, 6, 0.6, 0.5);
  NearestObstacleParameters parameters;
  EXPECT_LT(around(nearest_obstacle_grid(scene.frame(), half_metre_grid, parameters), half_metre_grid, 6, 0).largest,
            0.45F);
  parameters.filled_m = 0;
  const Image<float> cells{nearest_obstacle_grid(scene.frame(), half_metre_grid, parameters)};
  EXPECT_GT(around(cells, half_metre_grid, 6, 0).largest, 0.6F);
  EXPECT_NEAR(around(cells, half_metre_grid, 16, 0).largest, 0.5F, 1e-6F);
}

TEST(NearestObstacleGrid, OpenRoadMayBeUnknown) {
  NearestObstacleParameters parameters;
  parameters.open_road = false;
  EXPECT_THAT(values_of(nearest_obstacle_grid(DisparityScene{}.road().frame(), half_metre_grid, parameters)),
              Each(0.5F));
}

TEST(NearestObstacleGrid, DropsWhatTheRightCameraDoesNotSee) {
  NearestObstacleParameters parameters;
  parameters.grid.left_border_px = 30;
  const Image<float> cells{
      nearest_obstacle_grid(DisparityScene{}.road().wall(0, 240, 10, 2.5).frame(), half_metre_grid, parameters)};
  // columns below 10 + 30: y > (120 − 40)/200 · 10 = 4 m
  EXPECT_NEAR(around(cells, half_metre_grid, 10, 4.75, 0.25).largest, 0.5F, 1e-6F);
  EXPECT_GT(around(cells, half_metre_grid, 10, 3.0, 0.5).largest, 0.6F);
}

TEST(Stixels, CutsAColumnIntoGroundObjectsAndSky) {
  DisparityScene scene;
  scene.road().wall(0, 240, 16, 2.5).wall(0, 240, 8, 0.6);
  const auto columns{stixels(scene.frame())};
  const StixelParameters parameters;
  ASSERT_EQ(columns.size(), static_cast<std::size_t>((241 + parameters.column_px - 1) / parameters.column_px));
  for (const std::vector<Stixel>& column : columns) {
    ASSERT_EQ(column.size(), 4U);
    EXPECT_EQ(column[0].kind, StixelClass::ground);
    EXPECT_EQ(column[1].kind, StixelClass::object);
    EXPECT_EQ(column[2].kind, StixelClass::object);
    EXPECT_EQ(column[3].kind, StixelClass::sky);
    EXPECT_NEAR(column[1].disparity, 12.5, 1e-3);
    EXPECT_NEAR(column[2].disparity, 6.25, 1e-3);
    // the near wall's foot is at row 60 + 12.5·1.5/0.5 = 97.5, its top at 60 + 12.5·0.9/0.5 = 82.5
    EXPECT_NEAR(column[1].last_row, 97, 2);
    EXPECT_NEAR(column[1].first_row, 83, 2);
    EXPECT_EQ(column[0].last_row, 160);
  }
}

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
