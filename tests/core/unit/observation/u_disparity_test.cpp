// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"
#include "observation/u_disparity/model.hpp"
#include "support.hpp"
#include "u_disparity_run.hpp"

namespace stereogrid::test {
namespace {

// A world small enough for pencil and paper. v_hor = 2, H = 1 m, b = 0.5 m, h = 0.5 m: bin d is possible for the rows
// 2 + d … 2 + 2d, as far as the image's 12 rows reach. Every expected number below was computed by hand from them.
Rig tiny_rig() {
  return {5, 12, 100, 2, 2, 0.5, 1, 0, 0};
}

constexpr Ground tiny_ground{1, 0, 0, false};
constexpr int tiny_disparities{6};

BinConfig tiny_config() {
  BinConfig config;
  config.obstacle_height_m = 0.5;
  config.obstacle_min_height_m = 0;
  config.follow_roll = false;
  config.false_positive = 0.02;
  config.false_negative = 0.02;
  config.tau_obstacle = 0.5;
  config.tau_road = 0.5;
  config.sigma_disparity = 0.5;
  config.sigma_column = 1.5;
  config.road_rays = RoadRays::none;
  config.small_count_guard = 0;
  config.left_border = false;
  return config;
}

Matches tiny_matches() {
  Matches matches{5, 12};
  matches.obstacle(2, 5) = 3;
  matches.obstacle(2, 6) = 2.4f;  // bin 2
  matches.obstacle(2, 7) = 4.6f;  // bin 5
  matches.road(1, 9) = 3.2f;      // bin 3
  matches.road(2, 10) = 3.6f;     // bin 4
  matches.road(3, 8) = 2;
  matches.road(3, 11) = 4;
  return matches;
}

StageImages tiny_count(const BinConfig& config, const Matches& matches = tiny_matches(), int window_px = 3) {
  Reference reference;
  return counted(reference, matches, tiny_rig(), tiny_ground, config, tiny_disparities, window_px);
}

TEST(UDisparity, PossibleRows) {
  const Rig rig{tiny_rig()};
  // eq. 9: the road, v_0, is the lower end and the larger row
  EXPECT_EQ(possible_rows(rig, tiny_ground, 0.5, 3, 12).first, 5);
  EXPECT_EQ(possible_rows(rig, tiny_ground, 0.5, 3, 12).last, 8);
  // the upper end rounds up, the lower one down: 2 + 3·0.7/0.5 = 6.2 above 2 + 3·1/0.5 = 8; then v_0 = 2 + 3·1.1/0.5
  EXPECT_EQ(possible_rows(rig, tiny_ground, 0.3, 3, 12).first, 7);
  EXPECT_EQ(possible_rows(rig, {1.1, 0, 0, false}, 0.3, 3, 12).last, 8);
  // h above the camera: the rows reach above the horizon, to 2 − 0.6·d/0.5, and no further than the image
  EXPECT_EQ(possible_rows(rig, tiny_ground, 1.6, 1, 12).first, 1);
  EXPECT_EQ(possible_rows(rig, tiny_ground, 1.6, 5, 12).first, 0);
  // pitch: v_hor = 2 + 100·tan(0.03) = 5.00, slope 1/cos
  EXPECT_EQ(possible_rows(rig, {1, -0.03, 0, false}, 0.5, 2, 20).first, 8);
  EXPECT_EQ(possible_rows(rig, {1, -0.03, 0, false}, 0.5, 2, 20).last, 9);
}

TEST(UDisparity, Counts) {
  const StageImages stages{tiny_count(tiny_config())};
  EXPECT_EQ(stages.possible, (std::vector<int>{1, 2, 3, 4, 5, 5}));
  const int visible[]{0, 0, 1, 2, 1, 1};
  const int observed[]{0, 0, 1, 1, 0, 1};
  for (int d{0}; d < tiny_disparities; ++d) {
    EXPECT_EQ(stages.visible(2, d), visible[d]) << d;
    EXPECT_EQ(stages.observed(2, d), observed[d]) << d;
    EXPECT_EQ(stages.visible(1, d), 0) << d;
  }
}

TEST(UDisparity, RoadPixelsAreRaysWhenAskedFor) {
  BinConfig config{tiny_config()};
  config.road_rays = RoadRays::visible;
  const StageImages stages{tiny_count(config)};
  const int visible_2[]{0, 0, 1, 2, 2, 2};  // the road pixel in row 10 is in reach of bins 4 and 5
  const int visible_3[]{0, 0, 0, 1, 1, 2};  // row 8 of bins 3, 4, 5; row 11 of bin 5 only
  const int observed_2[]{0, 0, 1, 1, 0, 1};
  for (int d{0}; d < tiny_disparities; ++d) {
    EXPECT_EQ(stages.visible(2, d), visible_2[d]) << d;
    EXPECT_EQ(stages.visible(3, d), visible_3[d]) << d;
    EXPECT_EQ(stages.observed(2, d), observed_2[d]) << d;
  }
}

TEST(UDisparity, LowPixelsAreSeenButNoObstacle) {
  BinConfig config{tiny_config()};
  config.obstacle_min_height_m = 0.3;  // last row of bin 3: 2 + 3·(1 − 0.3)/0.5 = 6.2
  Matches matches{5, 12};
  for (int v{5}; v < 9; ++v) matches.obstacle(2, v) = 3;
  const StageImages stages{tiny_count(config, matches)};
  EXPECT_EQ(stages.visible(2, 3), 4);
  EXPECT_EQ(stages.observed(2, 3), 2) << "rows 5 and 6";
}

TEST(UDisparity, RowsTiltWithTheRoad) {
  BinConfig config{tiny_config()};
  config.follow_roll = true;
  Matches matches{17, 12};  // a column may be shifted by 17 / 8 = 2 rows
  for (int u : {1, 2, 4}) {
    for (int v{0}; v < 12; ++v) matches.obstacle(u, v) = 3;
  }
  const auto observed_with = [&](double roll_rad, int u) {
    Reference reference;
    Rig rig{tiny_rig()};
    rig.width_px = 17;
    return int{counted(reference, matches, rig, {1, 0, roll_rad, false}, config, tiny_disparities, 3).observed(u, 3)};
  };
  EXPECT_EQ(observed_with(0, 4), 4);
  // roll lifts the road on the right of u0 = 2 and lowers it on the left: the rows 5 … 8 of bin 3 move, none is lost
  EXPECT_EQ(observed_with(std::atan(0.5), 4), 4);
  for (int v{0}; v < 5; ++v) matches.obstacle(4, v) = matches.obstacle(1, v) = matches.obstacle(2, v) = 0;
  EXPECT_EQ(observed_with(std::atan(0.5), 2), 4);
  EXPECT_EQ(observed_with(std::atan(0.5), 4), 3) << "rows 4 … 7";
  EXPECT_EQ(observed_with(std::atan(-0.5), 4), 4) << "rows 6 … 9";
}

TEST(UDisparity, Probabilities) {
  const StageImages stages{tiny_count(tiny_config())};
  // bin (2, 3): P(V) = 2/4, r_O = 1/2, P(C) = 1 − e^−1, r_R = 4/9, P(R) = e^(−5/9/0.5)·e^−1
  EXPECT_NEAR(stages.visibility(2, 3), 0.5, 1e-6);
  EXPECT_NEAR(stages.obstacle_confidence(2, 3), 0.632121, 1e-6);
  EXPECT_NEAR(stages.road_confidence(2, 3), 0.121103, 1e-6);
  // P(O) = 0.5·0.632121·0.98 + 0.5·0.367879·0.02 + 0.5/2 = 0.563418; P(T) = 0.563418·(1 − 0.121103)
  EXPECT_NEAR(stages.occupancy(2, 3), 0.495186, 1e-6);
  // bin (2, 4): P(V) = 1/5, r_O = 0; road cells (1,3), (2,4), (3,4)
  EXPECT_NEAR(stages.visibility(2, 4), 0.2, 1e-6);
  EXPECT_EQ(stages.obstacle_confidence(2, 4), 0);
  EXPECT_NEAR(stages.road_confidence(2, 4), 0.263597, 1e-6);
  EXPECT_NEAR(stages.occupancy(2, 4), 0.297507, 1e-6);
  // bin (2, 5): P(V) = 1/5, r_O = 1, P(C) = 1 − e^−2; road cells (2,4), (3,4)
  EXPECT_NEAR(stages.obstacle_confidence(2, 5), 0.864665, 1e-6);
  EXPECT_NEAR(stages.road_confidence(2, 5), 0.028566, 1e-6);
  EXPECT_NEAR(stages.occupancy(2, 5), 0.553733, 1e-6);
  // bin (0, 1) and the road around it are unobserved
  EXPECT_EQ(stages.visibility(0, 1), 0);
  EXPECT_NEAR(stages.occupancy(0, 1), 0.5 * (1 - 0.135335), 1e-6);
}

TEST(UDisparity, BinsOutsideThePlaneCountAsNoRoad) {
  const StageImages stages{tiny_count(tiny_config())};
  // (0, 3) has road at (1, 3) only, of six cells within the plane: 1/9, not 1/6
  EXPECT_NEAR(stages.road_confidence(0, 3), std::exp(-(8.0 / 9) / 0.5), 1e-6);
  // (4, 5), a corner: (3, 4)
  EXPECT_NEAR(stages.road_confidence(4, 5), std::exp(-(8.0 / 9) / 0.5), 1e-6);
}

TEST(UDisparity, GuardWeakensSmallCounts) {
  BinConfig config{tiny_config()};
  config.small_count_guard = 2;
  const StageImages stages{tiny_count(config)};
  EXPECT_NEAR(stages.obstacle_confidence(2, 3), 0.393469, 1e-6);  // r_O = 1/(2 + 2)
  EXPECT_NEAR(stages.obstacle_confidence(2, 5), 0.486583, 1e-6);  // r_O = 1/(1 + 2)
  EXPECT_EQ(stages.obstacle_confidence(2, 1), 0);
}

TEST(UDisparity, RoadAllAroundIsFreeButNotWithCertainty) {
  Matches matches{5, 12};
  for (int u{1}; u <= 3; ++u) {
    matches.road(u, 6) = 2;
    matches.road(u, 8) = 3;
    matches.road(u, 10) = 4;
  }
  const StageImages stages{tiny_count(tiny_config(), matches)};
  EXPECT_EQ(stages.road_confidence(2, 3), 1);
  EXPECT_FLOAT_EQ(stages.occupancy(2, 3), 0.02f);  // and not 0.5·(1 − 1)
}

TEST(UDisparity, FilledColumnIsAsSureAsTheSensor) {
  BinConfig config{tiny_config()};
  config.tau_obstacle = 0.05;
  config.tau_road = 0.001;  // no road anywhere
  Matches matches{5, 12};
  for (int v{5}; v <= 8; ++v) matches.obstacle(2, v) = 3;
  const StageImages stages{tiny_count(config, matches)};
  EXPECT_EQ(stages.visibility(2, 3), 1);
  EXPECT_NEAR(stages.occupancy(2, 3), 0.98, 1e-6);
  // the rows of bin 4 that are seen end at the obstacle behind: rows 6, 7, 8 of five, none of them at bin 4
  EXPECT_NEAR(stages.visibility(2, 4), 0.6, 1e-6);
  EXPECT_NEAR(stages.occupancy(2, 4), 0.6 * 0.02 + 0.2, 1e-6);
  EXPECT_NEAR(stages.occupancy(2, 2), 0.5, 1e-6);
}

TEST(UDisparity, BinZeroIsUnknown) {
  Matches matches{tiny_matches()};
  matches.obstacle(2, 2) = 0.3f;  // rounds to bin 0: no measurement
  matches.road(3, 2) = 0.4f;
  const StageImages stages{tiny_count(tiny_config(), matches)};
  for (int u{0}; u < 5; ++u) {
    EXPECT_EQ(stages.occupancy(u, 0), 0.5f);
    EXPECT_EQ(stages.occupancy_smooth(u, 0), 0.5f);
    EXPECT_EQ(stages.visible(u, 0), 0);
  }
  // a road pixel of bin 0 does not count for its neighbours: (4, 1) has road at (3, 2) only
  EXPECT_NEAR(stages.road_confidence(4, 1), std::exp(-(8.0 / 9) / 0.5), 1e-6);
}

TEST(UDisparity, BinsLeftOfTheRightImageAreUnknown) {
  BinConfig config{tiny_config()};
  config.left_border = true;
  constexpr int window_px{5};
  const StageImages stages{tiny_count(config, tiny_matches(), window_px)};
  const StageImages without{tiny_count(tiny_config(), tiny_matches(), window_px)};
  for (const auto [u, d] : raster(0, 5, 1, tiny_disparities)) {
    EXPECT_EQ(stages.occupancy(u, d), u < d + 2 ? 0.5f : without.occupancy(u, d)) << u << " " << d;
  }
  EXPECT_NE(without.occupancy(2, 3), 0.5f);
}

// docs/method.md §5.5
TEST(GaussianWeights, AreIntegralsOverBins) {
  const std::vector<float> half{gaussian_weights(0.5)};
  ASSERT_EQ(half.size(), 5u);
  const double expected[]{0.00135, 0.157305, 0.68269, 0.157305, 0.00135};
  for (std::size_t k{0}; k < 5; ++k) EXPECT_NEAR(half[k], expected[k], 1e-6) << k;
  const std::vector<float> wide{gaussian_weights(1.5)};
  ASSERT_EQ(wide.size(), 11u);
  EXPECT_NEAR(wide[5], 0.261182, 1e-5);  // Φ(1/3) − Φ(−1/3)
  EXPECT_NEAR(wide[6], 0.210838, 1e-5);  // Φ(1) − Φ(1/3)
  for (const std::vector<float>& weights : {half, wide, gaussian_weights(3.3)}) {
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-6);
    for (std::size_t k{0}; k < weights.size(); ++k) EXPECT_EQ(weights[k], weights[weights.size() - 1 - k]);
  }
  EXPECT_EQ(gaussian_weights(0), std::vector<float>{1.0f});
}

TEST(Smoothing, LeavesAConstantAlone) {
  BinConfig config{tiny_config()};
  config.tau_road = 0.001;
  const StageImages stages{tiny_count(config, Matches{5, 12})};  // nothing seen: 0.5 everywhere
  for (const float p : stages.occupancy_smooth) EXPECT_NEAR(p, 0.5, 1e-6);
}

TEST(Smoothing, IsTheConvolutionWithRepeatedBorders) {
  // from the middle outwards
  const double along_disparity[]{0.682690, 0.157305, 0.001350};
  const double along_columns[]{0.261182, 0.210838, 0.110892, 0.037984, 0.008468, 0.001227};
  const StageImages stages{tiny_count(tiny_config())};
  for (const auto [u, d] : raster(0, 5, 1, tiny_disparities)) {
    double sum{0};
    for (int j{-2}; j <= 2; ++j) {
      for (int i{-5}; i <= 5; ++i) {
        sum += along_columns[std::abs(i)] * along_disparity[std::abs(j)] *
               stages.occupancy(std::clamp(u + i, 0, 4), std::clamp(d + j, 1, tiny_disparities - 1));
      }
    }
    EXPECT_NEAR(stages.occupancy_smooth(u, d), sum, 1e-5) << u << " " << d;
  }
}

// Fig. 6 of the paper: a person stands behind a box and is seen above it.
TEST(UDisparity, SeesWhoIsHalfHidden) {
  const Rig rig{small_kitti_rig()};
  BinConfig config{tiny_config()};
  config.obstacle_height_m = 1.8;
  config.tau_obstacle = config.tau_road = 0.1;
  constexpr int box{20};
  constexpr int person{10};
  Matches matches{rig.width_px, rig.height_px};
  for (int v{0}; v < rig.height_px; ++v) {
    const double of_box{row_at_height(rig, {1.65, 0, 0, false}, box, 0.9)};
    const double of_person{row_at_height(rig, {1.65, 0, 0, false}, person, 1.7)};
    for (int u{300}; u < 320; ++u) {
      if (v >= of_box && v <= row_at_height(rig, {1.65, 0, 0, false}, box, 0)) {
        matches.obstacle(u, v) = box;
      } else if (v >= of_person && v < of_box) {
        matches.obstacle(u, v) = person;
      }
    }
  }
  Reference reference;
  const StageImages stages{counted(reference, matches, rig, {1.65, 0, 0, false}, config, 32, 13)};
  constexpr int u{310};
  float nearest{0};  // the rule that ends at the first obstacle of a column has nothing behind it
  for (int v{0}; v < rig.height_px; ++v) nearest = std::max(nearest, matches.obstacle(u, v));
  ASSERT_GT(nearest, person);
  EXPECT_GT(stages.occupancy(u, box), 0.9);
  EXPECT_GT(stages.occupancy(u, person), 0.8);
  EXPECT_LT(stages.occupancy(u, 15), 0.4);         // between the two
  EXPECT_NEAR(stages.occupancy(u, 5), 0.5, 1e-3);  // behind both
  EXPECT_LT(stages.occupancy(u, 28), 0.25);        // in front
}

}  // namespace
}  // namespace stereogrid::test
