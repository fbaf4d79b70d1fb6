// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "figures/colour_map.hpp"
#include "figures/equations.hpp"
#include "figures/lidar_points.hpp"
#include "figures/panels.hpp"
#include "figures/reference_panels.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app::figures {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> texts(const std::vector<Tick>& ticks) {
  std::vector<std::string> all;
  for (const Tick& tick : ticks) all.push_back(tick.text);
  return all;
}

TEST(FigureMaths, TicksAreRoundNumbersWithinBothEnds) {
  EXPECT_THAT(texts(round_ticks(0, 1, 6)), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1"));
  EXPECT_THAT(texts(round_ticks(-0.5, 511.5, 8)), ElementsAre("0", "100", "200", "300", "400", "500"));
  EXPECT_THAT(texts(round_ticks(10, -10, 6)), ElementsAre("-10", "-5", "0", "5", "10"));
  EXPECT_THAT(texts(round_ticks(63.5, -0.5, 8)), ElementsAre("0", "10", "20", "30", "40", "50", "60"));
  EXPECT_THAT(texts(round_ticks(0, 0.3, 7)), ElementsAre("0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3"));
  EXPECT_THAT(round_ticks(3, 3, 5), IsEmpty());
  EXPECT_THAT(round_ticks(0, 1, 0), IsEmpty());
}

TEST(FigureMaths, NeverMoreTicksThanAskedFor) {
  for (const double range : {0.013, 0.7, 1.0, 3.0, 49.0, 1242.0}) {
    for (const int most : {2, 5, 8}) {
      const std::size_t ticks{round_ticks(0, range, most).size()};
      EXPECT_LE(ticks, static_cast<std::size_t>(most)) << range;
      EXPECT_GE(ticks, 1U) << range;
    }
  }
}

TEST(FigureMaths, AxesRunRightAndUp) {
  const Axis left{"y", 10, -10};
  EXPECT_EQ(along_x(left, 10, 400), 0);
  EXPECT_EQ(along_x(left, -10, 400), 400);
  const Axis ahead{"x", 0, 20};
  EXPECT_EQ(along_y(ahead, 20, 400), 0);
  EXPECT_EQ(along_y(ahead, 5, 400), 300);
}

TEST(FigureMaths, CountsAreLogarithmic) {
  EXPECT_EQ(count_share(0, 50), 0);
  EXPECT_EQ(count_share(50, 50), 1);
  EXPECT_NEAR(count_share(9, 99), 0.5, 1e-12);
  EXPECT_EQ(count_share(0, 0), 0);
}

TEST(FigureMaths, RoadPixelsAreCountedByDisparity) {
  Image<float> road(2, 4);
  road(0, 0) = 2.4F;
  road(0, 1) = 1.6F;
  road(0, 2) = 7.6F;   // beyond the last bin
  road(1, 3) = 0.25F;  // bin 0 is no measurement
  const Image<std::uint16_t> counts{road_counts(road, 8, 8)};
  EXPECT_EQ(counts(0, 2), 2);
  int all{0};
  for (const std::uint16_t count : counts) all += count;
  EXPECT_EQ(all, 2);
  // twice as many rows: bins of half a px
  const Image<std::uint16_t> finer{road_counts(road, 16, 8)};
  EXPECT_EQ(finer(0, 5), 1);
  EXPECT_EQ(finer(0, 3), 1);
  EXPECT_EQ(finer(0, 15), 1);
  EXPECT_EQ(finer(1, 1), 1);
}

TEST(FigureMaths, ALidarReturnLiesWhereItIsInTheVehicleFrame) {
  // velodyne x ahead, y left, z up; 0.3 m behind the camera and 0.1 m above it
  const io::Transform camera_from_velodyne{0, -1, 0, 0, 0, 0, -1, -0.1, 1, 0, 0, -0.3};
  Rig rig;
  const std::vector<io::ScanPoint> scan{{10.3F, 2, -1.25F, 0}};
  const auto at = [&](double pitch_rad) {
    Ground ground;
    ground.height_m = 1.65;
    ground.pitch_rad = pitch_rad;
    return in_vehicle(scan, camera_from_velodyne, rig, ground).at(0);
  };
  EXPECT_NEAR(at(0).x_m, 10, 1e-5);
  EXPECT_NEAR(at(0).y_m, 2, 1e-5);
  EXPECT_NEAR(at(0).height_m, 0.5, 1e-5);
  // a camera that looks down on the road has the road rise ahead of it, in its own frame
  EXPECT_NEAR(at(0.01).height_m, 1.65 - std::cos(0.01) * 1.15 - std::sin(0.01) * 10, 1e-5);
}

TEST(FigureMaths, APitchedCameraIsTurnedLevelFirst) {
  const double pitch{0.3};
  Rig rig;
  rig.camera_pitch_rad = pitch;
  // 8 m ahead and 1 m below the camera, as the camera that looks down by 0.3 rad has it
  const auto ahead{static_cast<float>(8 * std::cos(pitch) + 1 * std::sin(pitch))};
  const auto down{static_cast<float>(1 * std::cos(pitch) - 8 * std::sin(pitch))};
  const io::Transform same{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const LidarPoint point{in_vehicle({{0, down, ahead, 0}}, same, rig, {}).at(0)};
  EXPECT_NEAR(point.x_m, 8, 1e-5);
  EXPECT_NEAR(point.height_m, 0.65, 1e-5);
}

TEST(FigureMaths, AheadIsUpAndLeftIsLeft) {
  const GridGeometry grid{0, -2, 0.5, 4, 8};
  Image<float> occupancy(4, 8, 0);
  occupancy(3, 7) = 1;  // farthest, leftmost
  Rig rig{512, 320, 410, 256, 160, 0.22};
  const Panel panel{grid_panel("", occupancy, grid, rig, GridSize::small)};
  ASSERT_EQ(panel.picture.cols, 8 * 37);
  ASSERT_EQ(panel.picture.rows, 4 * 37);
  EXPECT_EQ(panel.picture.at<cv::Vec3b>(10, 10), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(panel.picture.at<cv::Vec3b>(10, panel.picture.cols - 10), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(panel.x.from, 2);
  EXPECT_EQ(panel.x.to, -2);
}

constexpr GridGeometry four_by_eight{0, -2, 0.5, 4, 8};

/// Colour in the middle of a cell; the rulers' lines may cross it elsewhere.
cv::Vec3b colour_of_cell(const Panel& panel, int ix, int iy) {
  const int cell_px{panel.picture.cols / four_by_eight.ny};
  return panel.picture.at<cv::Vec3b>((four_by_eight.nx - 1 - ix) * cell_px + cell_px / 2,
                                     (four_by_eight.ny - 1 - iy) * cell_px + cell_px / 2);
}

TEST(FigureMaths, LidarReturnsAreColouredByHeight) {
  const std::vector<LidarPoint> scan{{0.25, 1.25, 0.1}, {1.25, 1.25, 1}, {1.25, -1.75, 2.5}, {40, 0, 1}};
  const Panel panel{scan_panel("", scan, four_by_eight, Rig{512, 320, 410, 256, 160, 0.22})};
  const auto key = [&](std::size_t i) {
    const Colour colour{panel.keys.at(i).colour};
    return cv::Vec3b(colour.red, colour.green, colour.blue);
  };
  EXPECT_EQ(colour_of_cell(panel, 2, 6), key(0));
  EXPECT_EQ(colour_of_cell(panel, 0, 6), key(1));
  EXPECT_EQ(colour_of_cell(panel, 2, 0), key(2));
  EXPECT_EQ(colour_of_cell(panel, 3, 7), cv::Vec3b(255, 255, 255));
}

TEST(FigureMaths, TruthTellsSeenFromHidden) {
  FrameTruth truth;
  truth.state = Image<std::uint8_t>(4, 8, static_cast<std::uint8_t>(TruthCell::seen_free));
  truth.occupied = Image<std::uint8_t>(4, 8);
  truth.state(1, 7) = static_cast<std::uint8_t>(TruthCell::seen_occupied);
  truth.state(2, 7) = static_cast<std::uint8_t>(TruthCell::hidden);
  truth.state(3, 7) = static_cast<std::uint8_t>(TruthCell::hidden);
  truth.occupied(1, 7) = truth.occupied(2, 7) = 1;
  const Panel panel{truth_panel("", truth, four_by_eight, Rig{512, 320, 410, 256, 160, 0.22})};
  const auto key = [&](std::size_t i) {
    const Colour colour{panel.keys.at(i).colour};
    return cv::Vec3b(colour.red, colour.green, colour.blue);
  };
  EXPECT_EQ(colour_of_cell(panel, 1, 7), key(0));
  EXPECT_EQ(colour_of_cell(panel, 2, 7), key(1));
  EXPECT_EQ(colour_of_cell(panel, 0, 7), key(2));
  EXPECT_EQ(colour_of_cell(panel, 3, 7), key(3));
}

/// What the pipeline makes of a frame by the paper's formulas, and the shares that go into them.
class Formulas : public ::testing::Test {
 protected:
  Formulas()
      : scene_{scenes::parse_scene("scene:street?width=160&height=100&frames=1")},
        pipeline_{preset("paper"), scene_.rig()},
        stages_{pipeline_.process(scene_.load(0)).stages},
        config_{pipeline_.config().u_disparity},
        road_{
            road_counts(stages_.road_disparity, stages_.occupancy.height(), pipeline_.config().matching.disparities)} {}

  [[nodiscard]] double observed_share(int u, int d) const {
    return stages_.visible(u, d) > 0 ? static_cast<double>(stages_.observed(u, d)) / stages_.visible(u, d) : 0;
  }
  [[nodiscard]] double road_share(int u, int d) const {
    int filled{0};
    for (int dd{d - 1}; dd <= d + 1; ++dd) {
      for (int uu{u - 1}; uu <= u + 1; ++uu) {
        if (uu >= 0 && dd >= 1 && uu < road_.width() && dd < road_.height() && road_(uu, dd) > 0) ++filled;
      }
    }
    return filled / 9.0;
  }

  scenes::Scene scene_;
  Pipeline pipeline_;
  StageImages stages_;
  UDisparityConfig config_;
  Image<std::uint16_t> road_;
};

TEST_F(Formulas, AreThePipelines) {
  int obstacles{0};
  int roads{0};
  for (int d{1}; d < stages_.occupancy.height(); ++d) {
    for (int u{0}; u < stages_.occupancy.width(); ++u) {
      const double observed{observed_share(u, d)};
      const double confidence{obstacle_confidence(observed, config_.tau_obstacle)};
      const double road{road_confidence(road_share(u, d), observed, config_)};
      const double obstacle{obstacle_probability(static_cast<double>(stages_.visibility(u, d)), confidence, config_)};
      ASSERT_NEAR(confidence, static_cast<double>(stages_.obstacle_confidence(u, d)), 1e-5) << u << " " << d;
      ASSERT_NEAR(road, static_cast<double>(stages_.road_confidence(u, d)), 1e-5) << u << " " << d;
      ASSERT_NEAR(occupancy(obstacle, road, config_), static_cast<double>(stages_.occupancy(u, d)), 1e-5)
          << u << " " << d;
      obstacles += confidence > 0.5 ? 1 : 0;
      roads += road > 0.5 ? 1 : 0;
    }
  }
  EXPECT_GT(obstacles, 20);
  EXPECT_GT(roads, 100);
}

}  // namespace
}  // namespace stereogrid::app::figures
