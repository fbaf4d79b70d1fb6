// SPDX-License-Identifier: Apache-2.0
//
// The whole pipeline on disparities that are given: those of scenes, which are exact.
#include "chain_run.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

// Balanced log-loss of the observed grid over the cells that the camera sees.
class LogLoss {
 public:
  void add(const FrameTruth& truth, const Image<float>& observed) {
    for (const auto [ix, iy] : raster(observed)) {
      const auto state{static_cast<TruthCell>(truth.state(ix, iy))};
      const double p{std::clamp(static_cast<double>(observed(ix, iy)), 0.001, 0.999)};
      if (state == TruthCell::seen_occupied) add_to(occupied_, occupied_count_, -std::log(p));
      if (state == TruthCell::seen_free) add_to(free_, free_count_, -std::log(1 - p));
    }
  }
  [[nodiscard]] double mean() const { return (occupied_ / occupied_count_ + free_ / free_count_) / 2; }

 private:
  static void add_to(double& sum, int& count, double loss) {
    sum += loss;
    ++count;
  }
  double occupied_{0};
  double free_{0};
  int occupied_count_{0};
  int free_count_{0};
};

TEST(GivenChain, ExactDisparitiesAreAtLeastAsGoodAsMatchedOnes) {
  for (const char* text : {"street?frames=3", "crossing?frames=3", "crossing?frames=3&pitch_deg=4"}) {
    const Scene scene{text};
    Pipeline matching{preset("default"), scene.rig(), {.threads = 2}};
    Pipeline given{preset("default"), scene.rig(), {.threads = 2}};
    LogLoss of_matching;
    LogLoss of_given;
    for (std::size_t i{0}; i < scene.size(); ++i) {
      const FrameTruth truth{scene.truth(i)};
      of_matching.add(truth, matching.process(scene.load(i)).observed);
      of_given.add(truth, given.process(given_frame(scene, i)).observed);
    }
    EXPECT_LT(of_given.mean(), of_matching.mean()) << text;
    EXPECT_LT(of_given.mean(), 0.5) << text;
  }
}

TEST(GivenChain, RoadAndObstaclesAreDistinguished) {
  for (const char* text : {"street?frames=3", "street?frames=3&pitch_deg=3"}) {
    const Scene scene{text};
    Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2}};
    Pipeline matching{preset("default"), scene.rig(), {.threads = 2}};
    // labels of the truth belong to the pitched image, so only the level camera's are compared
    const bool level{std::abs(scene.rig().camera_pitch_rad) < 0.01};
    for (std::size_t i{0}; i < scene.size(); ++i) {
      const FrameTruth truth{scene.truth(i)};
      const FrameResult& result{pipeline.process(given_frame(scene, i))};
      EXPECT_TRUE(result.ground.estimated);
      EXPECT_NEAR(result.ground.height_m, scene.rig().camera_height_m, 0.02) << text;
      EXPECT_NEAR(result.ground.pitch_rad, 0, level ? 0.02 : 0.003) << text;
      if (!level) continue;
      int road{0};
      int called_obstacle{0};
      int matched_as_obstacle{0};
      const Image<float>& matched{matching.process(scene.load(i)).stages.obstacle_disparity};
      for (const auto [u, v] : raster(truth.label)) {
        if (static_cast<TruthLabel>(truth.label(u, v)) != TruthLabel::road) continue;
        ++road;
        called_obstacle += result.stages.obstacle_disparity(u, v) > 0 ? 1 : 0;
        matched_as_obstacle += matched(u, v) > 0 ? 1 : 0;
      }
      EXPECT_LT(called_obstacle, 0.006 * road) << "a row at the feet of obstacles";
      EXPECT_LT(called_obstacle, matched_as_obstacle);
    }
  }
}

TEST(GivenChain, APlaneThatIsFarOffIsFoundInTheFirstFrame) {
  const Scene scene{"street?frames=2"};
  for (const double off_rad : {0.015, -0.015}) {
    Rig rig{scene.rig()};
    rig.camera_pitch_rad += off_rad;
    Pipeline pipeline{preset("default"), rig, {.threads = 2}};
    const Ground ground{pipeline.process(given_frame(scene, 0)).ground};
    EXPECT_TRUE(ground.estimated);
    EXPECT_NEAR(ground.pitch_rad, scene.rig().camera_pitch_rad, 0.003) << off_rad;
    EXPECT_NEAR(ground.height_m, scene.rig().camera_height_m, 0.03) << off_rad;
  }
}

/// Cells of drops, and cells behind drops.
struct DropCells {
  int drops{0};
  int marked{0};
  int beyond{0};
  int free{0};
};

void count(const FrameTruth& truth, const Image<float>& observed, DropCells& cells) {
  for (std::size_t i{0}; i < observed.size(); ++i) {
    const auto kind{static_cast<TerrainCell>(truth.terrain.data()[i])};
    const float p{observed.data()[i]};
    if (kind == TerrainCell::drop) {
      ++cells.drops;
      cells.marked += p > 0.55f ? 1 : 0;
    }
    if (kind == TerrainCell::drop || kind == TerrainCell::beyond) {
      ++cells.beyond;
      cells.free += p < 0.45f ? 1 : 0;
    }
  }
}

// Points below the plane are matches like others.
TEST(GivenChain, DropsAreFoundAsInMatchedFrames) {
  for (const char* text : {"terrain?kind=edge&at=5&rise=-0.6&frames=2", "terrain?kind=edge&at=6&rise=-2&frames=2",
                           "terrain?kind=stairs&at=5&rise=-0.17&steps=8&frames=2"}) {
    SCOPED_TRACE(text);
    const Scene scene{text};
    Pipeline matching{preset("default"), scene.rig(), {.threads = 2}};
    Pipeline given{preset("default"), scene.rig(), {.threads = 2}};
    Pipeline own{preset("default"), scene.rig(), {.threads = 2}};
    DropCells by_matching;
    DropCells by_truth;
    DropCells by_own;
    for (std::size_t i{0}; i < scene.size(); ++i) {
      const FrameTruth truth{scene.truth(i)};
      count(truth, given.process(given_frame(scene, i)).observed, by_truth);
      const FrameResult& matched{matching.process(scene.load(i))};
      count(truth, matched.observed, by_matching);
      StereoFrame frame{given_frame(scene, i)};
      for (std::size_t k{0}; k < frame.disparity.size(); ++k) {
        frame.disparity.data()[k] =
            std::max(matched.stages.obstacle_disparity.data()[k], matched.stages.road_disparity.data()[k]);
      }
      const FrameResult& from_own{own.process(frame)};
      EXPECT_EQ(from_own.status, matched.status);
      count(truth, from_own.observed, by_own);
    }
    for (const DropCells& cells : {by_truth, by_own}) {
      ASSERT_GT(by_matching.marked, 25);
      EXPECT_GE(cells.marked, 0.75 * by_matching.marked) << "an edge may lie in the next cell";
      EXPECT_LE(cells.free, 0.002 * cells.beyond);
    }
  }
}

// The pedestrian, the car and the cyclist of a crossing, with the disparities at both ends of tracked features.
TEST(GivenChain, WhatMovesIsSeenToMove) {
  const Scene scene{"crossing?frames=12"};
  for (const bool with_right : {false, true}) {
    Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2}};
    std::vector<double> errors_mps;
    for (std::size_t i{0}; i < scene.size(); ++i) {
      StereoFrame frame{given_frame(scene, i)};
      if (with_right) frame.right = scene.load(i).right;
      const FrameResult& result{pipeline.process(frame)};
      if (i < 6) continue;
      const FrameTruth truth{scene.truth(i)};
      for (std::size_t k{0}; k < truth.state.size(); ++k) {
        const double vx{truth.velocity_x.data()[k]};
        const double vy{truth.velocity_y.data()[k]};
        if (static_cast<TruthCell>(truth.state.data()[k]) != TruthCell::seen_occupied || std::hypot(vx, vy) < 0.5)
          continue;
        errors_mps.push_back(std::hypot(result.vehicle.velocity_x.data()[k] - vx,  //
                                        result.vehicle.velocity_y.data()[k] - vy));
      }
    }
    ASSERT_GT(errors_mps.size(), 30U);
    const auto middle = errors_mps.begin() + static_cast<std::ptrdiff_t>(errors_mps.size() / 2);
    std::ranges::nth_element(errors_mps, middle);
    EXPECT_LT(*middle, 0.3) << with_right;
  }
}

TEST(GivenChain, CpuEqualsReference) {
  const Scene scene{"street?width=123&height=77&frames=3"};
  Config config{preset("default")};
  config.grid.length_m = 8;
  config.filter.speeds_mps = {1.25, 2.5, 3.9};
  Pipeline reference{config, scene.rig(), {.back_end = BackEnd::reference}};
  Pipeline cpu{config, scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i < 3; ++i) {
    const FrameResult& a{reference.process(given_frame(scene, i))};
    const FrameResult& b{cpu.process(given_frame(scene, i))};
    EXPECT_EQ(a.ground, b.ground);
    EXPECT_EQ(a.stages.obstacle_disparity, b.stages.obstacle_disparity);
    EXPECT_EQ(a.stages.road_disparity, b.stages.road_disparity);
    EXPECT_EQ(a.world.occupancy, b.world.occupancy);
  }
}

TEST(GivenChain, MatchedAndGivenFramesMayTakeTurns) {
  const Scene scene{"street?width=160&height=100&frames=3"};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2}};
  pipeline.process(scene.load(0));
  EXPECT_GT(pipeline.process(given_frame(scene, 1)).road_density, 0.3);
  EXPECT_GT(pipeline.process(scene.load(2)).road_density, 0.05);
}

void expect_refused(Pipeline& pipeline, const StereoFrame& frame, const char* words) {
  const std::string text{error_text_of<InputError>([&] { pipeline.process(frame); })};
  EXPECT_NE(text.find(words), std::string::npos) << text;
}

TEST(GivenChain, RefusesFramesThatAreNoPair) {
  const Scene scene{"street?width=160&height=100&frames=2"};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2}};
  StereoFrame frame{given_frame(scene, 0)};
  frame.disparity = {};
  expect_refused(pipeline, frame, "neither a right image nor disparities");
  frame.disparity = Image<float>{160, 99};
  expect_refused(pipeline, frame, "160 × 100");
  frame.disparity = scene.truth(0).disparity;
  frame.left = {};
  expect_refused(pipeline, frame, "160 × 100");
  pipeline.process(given_frame(scene, 0));
}

TEST(GivenChain, WithoutAnyDisparityNothingIsKnown) {
  const Scene scene{"street?width=160&height=100&frames=1"};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2}};
  StereoFrame frame{given_frame(scene, 0)};
  frame.disparity.fill(0);
  const FrameResult& result{pipeline.process(frame)};
  EXPECT_FALSE(result.ground.estimated);
  EXPECT_EQ(result.status, std::vector{FrameStatus::few_matches});
  EXPECT_EQ(result.speed_limit_mps, 0);
  for (const float p : result.observed) EXPECT_NEAR(p, 0.5, 0.01);
}

}  // namespace
}  // namespace stereogrid::test
