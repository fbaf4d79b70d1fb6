// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/external.hpp"

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr double by_noise{2};  // standard deviations within which a pixel counts as road

MatchingConfig config_for(double sigma_px) {
  MatchingConfig config;
  config.disparities = 128;
  config.external_sigma_px = sigma_px;
  return config;
}

Ground fitted_ground() {
  return {1.6, 0.01, 0.02, true};
}

// Disparity of a point `height_m` above the road on the ray of a pixel.
float disparity_at(const Rig& rig, const Ground& ground, int u, int v, double height_m) {
  return static_cast<float>(road_plane(rig, ground).disparity(u, v) / (1 - height_m / ground.height_m));
}

enum class Label { none, road, obstacle };

// Label of a disparity at a pixel, all others being empty.
Label label_of(const Rig& rig, const Ground& ground, const MatchingConfig& config, int u, int v, float d) {
  Image<float> disparity{rig.width_px, rig.height_px};
  disparity(u, v) = d;
  Matches matches{rig.width_px, rig.height_px};
  matches.road.fill(7);
  matches.obstacle.fill(7);
  Reference reference;
  split(reference, disparity.view(), rig, ground, config, matches);
  const float road{matches.road(u, v)};
  const float obstacle{matches.obstacle(u, v)};
  EXPECT_TRUE(road == 0 || obstacle == 0) << "no pixel has both";
  EXPECT_TRUE((road == 0 && obstacle == 0) || road + obstacle == d) << "as it was given";
  return road > 0 ? Label::road : obstacle > 0 ? Label::obstacle : Label::none;
}

TEST(Given, LabelsByTheHeightAboveTheRoad) {
  const Rig rig{small_kitti_rig()};
  const Ground ground{fitted_ground()};
  const MatchingConfig config{config_for(0.3)};
  for (const int u : {40, 300, 600}) {
    for (const int v : {130, 150, 187}) {  // the near road, where 0.15 m is more than the noise
      const auto label_at = [&](double height_m) {
        return label_of(rig, ground, config, u, v, disparity_at(rig, ground, u, v, height_m));
      };
      EXPECT_EQ(label_at(0), Label::road);
      EXPECT_EQ(label_at(0.12), Label::road) << "a kerb";
      EXPECT_EQ(label_at(0.14), Label::road);
      EXPECT_EQ(label_at(0.16), Label::obstacle);
      EXPECT_EQ(label_at(0.8), Label::obstacle);
      EXPECT_EQ(label_at(-0.14), Label::road);
      EXPECT_EQ(label_at(-0.16), Label::obstacle) << "below the road";
      EXPECT_EQ(label_at(-3), Label::obstacle);
    }
  }
}

TEST(Given, AboveTheHorizonThereIsNoRoad) {
  const Rig rig{small_kitti_rig()};
  const MatchingConfig config{config_for(0.3)};
  EXPECT_EQ(label_of(rig, fitted_ground(), config, 300, 20, 5), Label::obstacle);
  EXPECT_EQ(label_of(rig, fitted_ground(), config, 300, 20, 0.6f), Label::obstacle);
}

TEST(Given, FarAwayNoiseDecides) {
  const Rig rig{small_kitti_rig()};
  const HeightTest test{rig, Ground{1.6, 0, 0, true}, config_for(0.7)};
  const float r{5};  // 0.15 m are only 0.5 px there
  EXPECT_TRUE(test.is_on_road(r + 1.39f, r, 0));
  EXPECT_FALSE(test.is_on_road(r + 1.41f, r, 0));
  EXPECT_TRUE(test.is_on_road(r - 1.39f, r, 0));
  EXPECT_FALSE(test.is_on_road(r - 1.41f, r, 0));
}

struct PlaneSigmas {
  double height_m;
  double pitch_rad;
  double roll_rad;
};

double margin(const Rig& rig, double height_m, const PlaneSigmas& sigmas, double x, double r) {
  Ground ground{height_m, 0, 0, true};
  ground.height_sigma_m = sigmas.height_m;
  ground.pitch_sigma_rad = sigmas.pitch_rad;
  ground.roll_sigma_rad = sigmas.roll_rad;
  const HeightTest test{rig, ground, config_for(1e-7)};
  return std::sqrt(test.margin2(static_cast<float>(r), static_cast<float>(x)));
}

TEST(Given, UncertaintyOfThePlaneWidensTheMargin) {
  const Rig rig{small_kitti_rig()};
  const double height_m{1.5};
  const double scale{rig.baseline_m / height_m};
  const double by_height{margin(rig, height_m, {0.03, 0, 0}, 0, 20)};
  const double by_pitch{margin(rig, height_m, {0, 0.002, 0}, 0, 20)};
  EXPECT_NEAR(by_height, by_noise * 20 * 0.03 / height_m, 1e-5);
  EXPECT_NEAR(by_pitch, by_noise * scale * rig.focal_px * 0.002, 1e-5);
  EXPECT_NEAR(margin(rig, height_m, {0, 0, 0.01}, -200, 20), by_noise * scale * 200 * 0.01, 1e-5);
  EXPECT_NEAR(margin(rig, height_m, {0, 0, 0.01}, 0, 20), 0, 1e-6);
  EXPECT_NEAR(margin(rig, height_m, {0.03, 0.002, 0}, 0, 20), std::hypot(by_height, by_pitch), 1e-5);
}

// The margins above are the derivatives of the plane's disparity.
TEST(Given, TheMarginCoversPlanesWithinTheirSigmas) {
  const Rig rig{small_kitti_rig()};
  const Ground ground{1.5, 0.02, -0.01, true};
  for (const PlaneSigmas& sigmas : {PlaneSigmas{0.01, 0, 0}, PlaneSigmas{0, 0.001, 0}, PlaneSigmas{0, 0, 0.002}}) {
    Ground moved{ground};
    moved.height_m += by_noise * sigmas.height_m;
    moved.pitch_rad += by_noise * sigmas.pitch_rad;
    moved.roll_rad += by_noise * sigmas.roll_rad;
    for (const int u : {20, 305, 610}) {
      const double before{road_plane(rig, ground).disparity(u, 150)};
      const double after{road_plane(rig, moved).disparity(u, 150)};
      const double expected{margin(rig, ground.height_m, sigmas, u - rig.cx_px, before)};
      EXPECT_NEAR(std::abs(after - before), expected, 0.03 * expected + 2e-3) << u;
    }
  }
}

TEST(Given, ALowCameraKeepsItsObstaclesAboveTheHorizonOnly) {
  Rig rig{small_kitti_rig()};
  Ground ground{fitted_ground()};
  ground.height_m = 0.1;  // lower than what counts as road
  const MatchingConfig config{config_for(0.3)};
  EXPECT_EQ(label_of(rig, ground, config, 300, 150, disparity_at(rig, ground, 300, 150, 0.05) / 8), Label::obstacle);
  EXPECT_EQ(label_of(rig, ground, config, 300, 88, 60), Label::road) << "nothing on a ray to the ground is higher";
  EXPECT_EQ(label_of(rig, ground, config, 300, 20, 60), Label::obstacle);
}

TEST(Given, AnUncertainPlaneIsTrustedLess) {
  const Rig rig{small_kitti_rig()};
  Ground ground{fitted_ground()};
  const MatchingConfig config{config_for(0.3)};
  const float d{static_cast<float>(road_plane(rig, ground).disparity(300, 150)) + 3.0f};
  EXPECT_EQ(label_of(rig, ground, config, 300, 150, d), Label::obstacle);
  ground.pitch_sigma_rad = 0.0125;
  EXPECT_EQ(label_of(rig, ground, config, 300, 150, d), Label::road);
}

TEST(Given, WhatIsNoDisparityIsLeftOut) {
  const Rig rig{small_kitti_rig()};
  const MatchingConfig config{config_for(0.3)};
  for (const float d : {0.0f, -1.0f, 0.49f, 127.5f, 1000.0f, std::numeric_limits<float>::quiet_NaN(),
                        std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(label_of(rig, fitted_ground(), config, 300, 20, d), Label::none) << d;
  }
  EXPECT_EQ(label_of(rig, fitted_ground(), config, 300, 20, 127.4f), Label::obstacle);
}

Image<float> random_disparities(const Rig& rig, unsigned seed) {
  std::mt19937 generator{seed};
  Image<float> disparity{rig.width_px, rig.height_px};
  for (float& d : disparity) d = static_cast<float>(uniform(generator, -5, 70));
  return disparity;
}

TEST(Given, ThreadsAndVectorsChangeNothing) {
  Rig rig{small_kitti_rig()};
  rig.width_px = 131;
  rig.height_px = 97;
  const Image<float> disparity{random_disparities(rig, 3)};
  const MatchingConfig config{config_for(0.5)};
  std::mt19937 generator{5};
  Image<std::int16_t> rows{2 * config.disparities, relief_sectors(rig.width_px)};
  for (std::int16_t& raised : rows) raised = static_cast<std::int16_t>(uniform(generator, -4, 4));
  Matches expected{rig.width_px, rig.height_px};
  Matches expected_surfaces{rig.width_px, rig.height_px};
  Image<float> heights{rig.width_px, rig.height_px};
  Reference reference;
  const Relief<Host> relief{rows.view()};
  split(reference, disparity.view(), rig, fitted_ground(), config, expected);
  split_surfaces(reference, disparity.view(), rig, fitted_ground(), relief, config, heights, expected_surfaces);
  for (const int threads : {1, 2}) {
    Cpu cpu{threads};
    Matches matches{rig.width_px, rig.height_px};
    split(cpu, disparity.view(), rig, fitted_ground(), config, matches);
    EXPECT_EQ(count_differences(matches.road, expected.road), 0);
    EXPECT_EQ(count_differences(matches.obstacle, expected.obstacle), 0);
    split_surfaces(cpu, disparity.view(), rig, fitted_ground(), relief, config, heights, matches);
    EXPECT_EQ(count_differences(matches.road, expected_surfaces.road), 0);
    EXPECT_EQ(count_differences(matches.obstacle, expected_surfaces.obstacle), 0);
  }
}

/// A board that stands on the road, with noise of the disparities, and its labels.
struct Board {
  static constexpr int first_u{280};
  static constexpr int end_u{320};
  static constexpr int foot_v{130};

  explicit Board(double noise_px, int raised_rows = 0) {
    std::mt19937 generator{11};
    const RoadPlane plane{road_plane(rig, fitted_ground())};
    for (const auto [u, v] : raster(rig.width_px, rig.height_px)) {
      const int row{u >= first_u && u < end_u && v < foot_v ? foot_v : v};
      const double d{plane.disparity(u, row + raised_rows) + uniform(generator, -noise_px, noise_px)};
      disparity(u, v) = static_cast<float>(std::max(d, 0.0));
    }
    Image<std::int16_t> rows{256, relief_sectors(rig.width_px)};
    rows.fill(static_cast<std::int16_t>(raised_rows));
    Image<float> heights{rig.width_px, rig.height_px};
    Cpu cpu{1};
    split_surfaces(cpu, disparity.view(), rig, fitted_ground(), {rows.view()}, config_for(0), heights, matches);
  }

  /// Share of obstacle pixels in rows first … end − 1 of the board's columns.
  [[nodiscard]] double obstacles(int first_v, int end_v) const {
    int count{0};
    for (const auto [u, v] : raster(first_u + 1, end_u - 1, first_v, end_v))
      count += matches.obstacle(u, v) > 0 ? 1 : 0;
    return count / (1.0 * (end_v - first_v) * (end_u - first_u - 2));
  }

  Rig rig{small_kitti_rig()};
  Image<float> disparity{rig.width_px, rig.height_px};
  Matches matches{rig.width_px, rig.height_px};
};

TEST(Given, FeetOfObstaclesAreUprightAndNoisyGroundIsRoad) {
  for (const double noise_px : {0.0, 0.3, 0.6}) {
    for (const int raised_rows : {0, 12, -12}) {  // a ramp's
      const Board board{noise_px, raised_rows};
      EXPECT_GT(board.obstacles(Board::foot_v - 20, Board::foot_v - 2), 0.95) << noise_px << " " << raised_rows;
      EXPECT_LT(board.obstacles(Board::foot_v + 3, board.rig.height_px), 0.05) << noise_px << " " << raised_rows;
    }
  }
}

TEST(Given, StepOfRoundedDisparities) {
  const Rig rig{small_kitti_rig()};
  for (const double step : {1.0, 0.5, 0.25}) {
    Image<float> disparity{random_disparities(rig, 4)};
    for (float& d : disparity) d = static_cast<float>(std::round(d / step) * step);
    EXPECT_EQ(step_of(disparity.view()), step);
  }
  EXPECT_EQ(step_of(random_disparities(rig, 4).view()), 0);
  EXPECT_EQ(step_of({}), 0);
}

}  // namespace
}  // namespace stereogrid::test
