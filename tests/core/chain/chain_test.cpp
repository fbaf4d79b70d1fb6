// SPDX-License-Identifier: Apache-2.0
//
// The whole pipeline on scenes whose truth is known: would catch a wrong sign anywhere on the way.
#include "chain_run.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

bool is_cell(const Image<std::uint8_t>& state, int ix, int iy, TruthCell wanted) {
  return state(ix, iy) == static_cast<std::uint8_t>(wanted);
}

double centre_x(const GridGeometry& grid, int ix) {
  return grid.x_min_m + (ix + 0.5) * grid.cell_size_m;
}
double centre_y(const GridGeometry& grid, int iy) {
  return grid.y_min_m + (iy + 0.5) * grid.cell_size_m;
}

const Obstacle* nearest(const std::vector<Obstacle>& obstacles, double x_m, double y_m, double reach_m) {
  const Obstacle* found{nullptr};
  for (const Obstacle& obstacle : obstacles) {
    const double distance{std::hypot(obstacle.x_m - x_m, obstacle.y_m - y_m)};
    if (!obstacle.confirmed || distance > reach_m) continue;
    reach_m = distance;
    found = &obstacle;
  }
  return found;
}

// Crate of the scene `occlusion`: face at x = 6.0, y from −0.6 to 0.6.
void expect_crate_in_place(const FrameResult& result) {
  const GridGeometry& grid{result.vehicle.geometry};
  const auto occupied = [&](double x_m, double y_m) {
    return result.observed(static_cast<int>((x_m - grid.x_min_m) / grid.cell_size_m),
                           static_cast<int>((y_m - grid.y_min_m) / grid.cell_size_m)) > 0.5f;
  };
  double first_x{0};
  while (first_x < 19 && !occupied(first_x + 0.1, 0.1)) first_x += grid.cell_size_m;
  EXPECT_NEAR(first_x, 6.0, 0.21) << "nearest occupied cell straight ahead";
  double left_edge{0.1};
  while (left_edge < 5 && occupied(6.1, left_edge)) left_edge += grid.cell_size_m;
  double right_edge{-0.1};
  while (right_edge > -5 && occupied(6.1, right_edge)) right_edge -= grid.cell_size_m;
  EXPECT_NEAR(left_edge, 0.7, 0.21);
  EXPECT_NEAR(right_edge, -0.7, 0.21);
}

TEST(Chain, PutsAnObstacleIntoItsCell) {
  Drive run{"occlusion?width=1242&height=375"};
  expect_crate_in_place(run.step(0));
}

TEST(Chain, LevelsAPitchedCamera) {
  Drive run{"occlusion?width=1242&height=375&pitch_deg=3"};
  const FrameResult& result{run.step(0)};
  expect_crate_in_place(result);
  EXPECT_LT(std::abs(result.ground.pitch_rad), 0.005) << "the stages see level images";
}

struct FreeCells {
  int seen{0};
  int free{0};

  void add(float p) {
    ++seen;
    free += p < 0.45f ? 1 : 0;
  }
};

// Cells are unknown where the road has too little texture, mostly at the edges of the view and beyond 15 m. Noise in
// the sky matches in a few patches near the horizon, elsewhere in each frame. From the fourth frame on the filtered
// grid has one in 2,000 at most (decisions 26, 27).
TEST(Chain, KeepsAnEmptyRoadFree) {
  Drive run{"empty"};
  FreeCells all;
  FreeCells inner;
  FreeCells filtered;
  int occupied{0};
  int filtered_occupied{0};
  for (std::size_t i{0}; i < 10; ++i) {
    const FrameResult& result{run.step(i)};
    const FrameTruth truth{run.scene.truth(i)};
    for (int iy{0}; iy < result.observed.height(); ++iy) {
      const double y{centre_y(result.vehicle.geometry, iy)};
      for (int ix{10}; ix < result.observed.width(); ++ix) {
        if (!is_cell(truth.state, ix, iy, TruthCell::seen_free)) continue;
        occupied += result.observed(ix, iy) >= 0.75f ? 1 : 0;
        all.add(result.observed(ix, iy));
        const double x{centre_x(result.vehicle.geometry, ix)};
        if (x > 3 && x < 15 && std::abs(y) < 0.5 * x) inner.add(result.observed(ix, iy));
        if (i < 3) continue;
        filtered.add(result.vehicle.occupancy(ix, iy));
        filtered_occupied += result.vehicle.occupancy(ix, iy) >= 0.75f ? 1 : 0;
      }
    }
    EXPECT_EQ(std::count_if(result.obstacles.begin(), result.obstacles.end(),
                            [](const Obstacle& obstacle) { return obstacle.confirmed; }),
              0);
  }
  EXPECT_LT(occupied, 0.005 * all.seen);
  EXPECT_LE(filtered_occupied, 0.0005 * filtered.seen);
  EXPECT_GT(all.free, 0.91 * all.seen);
  EXPECT_GT(inner.free, 0.98 * inner.seen);
}

TEST(Chain, IsUnknownBehindAWall) {
  Drive run{"wall"};
  for (std::size_t i{0}; i < 3; ++i) {
    const FrameResult& result{run.step(i)};
    const GridGeometry& grid{result.vehicle.geometry};
    for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
      if (centre_x(grid, ix) < 10 || std::abs(centre_y(grid, iy)) > 5) continue;
      EXPECT_NEAR(result.observed(ix, iy), 0.5, 0.03);
      EXPECT_NEAR(result.vehicle.occupancy(ix, iy), 0.5, 0.03);
      EXPECT_TRUE(std::isinf(result.vehicle.age_s(ix, iy)));
    }
    EXPECT_GT(highest_near(result.observed, grid, {8.0, 0.0}, 0.3), 0.75);
    EXPECT_LT(highest_near(result.observed, grid, {5.0, 0.0}, 0.5), 0.3);
  }
}

TEST(Chain, SeesTheCarOnTheLeftAndNothingOnTheRight) {
  Drive run{"crossing"};
  const FrameResult& result{run.step(9)};  // the car is at x = 13, y = 5.6
  EXPECT_GT(highest_near(result.observed, result.vehicle.geometry, {13.0, 5.6}, 0.6), 0.7);
  EXPECT_LT(highest_near(result.observed, result.vehicle.geometry, {13.0, -5.6}, 0.6), 0.6);
}

// Frames given to the pipeline; the velocities after 1.4 s must be those of the scene. From frame 18 on the walker
// hides the car's middle.
void expect_crossing_velocities(const std::vector<std::size_t>& frames) {
  Drive run{"crossing"};
  for (const std::size_t i : frames) {
    const FrameResult& result{run.step(i)};
    const FrameTruth truth{run.scene.truth(i)};
    for (const TruthObject& object : truth.objects) {
      if (std::abs(object.vy_mps) < 0.5 || i < 14) continue;
      const Point2 at{object.world_from_object.x_m, object.world_from_object.y_m};
      if (std::abs(at.y) > 5) continue;
      const Obstacle* found{nearest(result.obstacles, at.x, at.y, 2.0)};
      ASSERT_NE(found, nullptr) << object.kind << " in frame " << i;
      EXPECT_NEAR(found->vy_mps, object.vy_mps, 0.2 * std::abs(object.vy_mps) + 0.5) << object.kind << " " << i;
      EXPECT_NEAR(found->vx_mps, 0, 1.0) << object.kind << " " << i;
    }
  }
}

TEST(Chain, MeasuresVelocitiesInDirectionAndSize) {
  std::vector<std::size_t> frames;
  for (std::size_t i{0}; i < 24; ++i) frames.push_back(i);
  expect_crossing_velocities(frames);
}

TEST(Chain, BridgesMissingFrames) {
  std::vector<std::size_t> frames;
  for (std::size_t i{0}; i < 26; ++i) {
    if (i % 5 != 3) frames.push_back(i);
  }
  expect_crossing_velocities(frames);
}

TEST(Chain, StandingThingsStandWhileTheCarMoves) {
  Drive run{"street"};
  int cells{0};
  int moving{0};
  for (std::size_t i{0}; i < 15; ++i) {
    const FrameResult& result{run.step(i)};
    const FrameTruth truth{run.scene.truth(i)};
    EXPECT_NEAR(result.world_from_vehicle.x_m, truth.ego.world_from_vehicle.x_m, 1e-9);
    if (i < 5) continue;
    for (const auto [ix, iy] : raster(result.vehicle.occupancy)) {
      const bool stands{truth.velocity_x(ix, iy) == 0 && truth.velocity_y(ix, iy) == 0};
      if (!stands || !is_cell(truth.state, ix, iy, TruthCell::seen_occupied)) continue;
      if (result.vehicle.occupancy(ix, iy) < 0.6f) continue;
      ++cells;
      moving += std::hypot(result.vehicle.velocity_x(ix, iy), result.vehicle.velocity_y(ix, iy)) > 1 ? 1 : 0;
    }
  }
  EXPECT_GT(cells, 1000);
  EXPECT_LT(moving, 0.02 * cells);
}

TEST(Chain, RefusesAFrameThatDoesNotFitAndGoesOn) {
  Drive run{"crossing?width=160&height=100"};
  Drive undisturbed{"crossing?width=160&height=100"};
  run.step(0);
  undisturbed.step(0);
  StereoFrame wrong_size{run.scene.load(1)};
  wrong_size.right = Image<std::uint8_t>{159, 100};
  EXPECT_THROW(run.pipeline.process(wrong_size), InputError);
  StereoFrame of_the_past{run.scene.load(1)};
  of_the_past.stamp_ns = 0;
  EXPECT_THROW(run.pipeline.process(of_the_past), InputError);
  StereoFrame nowhere{run.scene.load(1)};
  nowhere.world_from_vehicle = Pose2{NAN, 0, 0};
  EXPECT_THROW(run.pipeline.process(nowhere), InputError);
  expect_equal(undisturbed.step(1), run.step(1));
}

TEST(Chain, SaysThatItHasNoPoses) {
  Drive run{"crossing?width=160&height=100"};
  StereoFrame frame{run.scene.load(0)};
  frame.world_from_vehicle.reset();
  EXPECT_EQ(run.pipeline.process(frame).warnings.size(), 1u);
  frame.stamp_ns += 100'000'000;
  EXPECT_TRUE(run.pipeline.process(frame).warnings.empty()) << "once is enough";
}

TEST(Chain, WorldBeginsAtTheFirstFrame) {
  Drive run{"street?width=160&height=100"};
  const FrameResult& result{run.step(7)};
  EXPECT_NEAR(result.world_from_vehicle.x_m, 0, 1e-9);
  EXPECT_NEAR(result.world_from_vehicle.y_m, 0, 1e-9);
  EXPECT_NEAR(result.world_from_vehicle.yaw_rad, 0, 1e-9);
}

double mean_difference(const Image<float>& a, const Image<float>& b) {
  double sum{0};
  for (std::size_t i{0}; i < a.size(); ++i) sum += std::abs(a.data()[i] - b.data()[i]);
  return sum / static_cast<double>(a.size());
}

// Poses jump at frame 6 by 3 m and 20°.
TEST(Chain, APoseJumpDoesNotSmearTheGrid) {
  const char* const scene{"street?width=256&height=160&frames=8"};
  Drive undisturbed{scene};
  Drive noticing{scene};
  Config config{preset("default")};
  config.motion.detect_jumps = false;
  Drive following{scene, config};
  for (std::size_t i{0}; i < 8; ++i) {
    StereoFrame frame{noticing.scene.load(i)};
    if (i >= 6) frame.world_from_vehicle = Pose2{3, -1, 0.35} * *frame.world_from_vehicle;
    const FrameResult& noticed{noticing.pipeline.process(frame)};
    EXPECT_EQ(noticed.warnings.size(), i == 6 ? 1u : 0u) << i;
    const FrameResult& followed{following.pipeline.process(frame)};
    const FrameResult& expected{undisturbed.step(i)};
    if (i < 6) continue;
    EXPECT_LT(mean_difference(noticed.vehicle.occupancy, expected.vehicle.occupancy), 0.005);
    EXPECT_GT(mean_difference(followed.vehicle.occupancy, expected.vehicle.occupancy), 0.03);
  }
}

TEST(Chain, ReportsEveryProblemOfItsSettings) {
  Config config;
  config.matching.window_px = 8;
  config.grid.cell_size_m = -1;
  const std::string text{error_text_of<ConfigError>([&] { Pipeline{config, Rig{}}; })};
  for (const char* word : {"window_px", "cell_size_m", "image size", "baseline_m", "focal_px"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
}

TEST(Chain, TakesImagesNarrowerThanTheDisparities) {
  Config config;
  config.matching.disparities = 64;
  Drive run{"crossing?width=24&height=17", config};
  const FrameResult& result{run.step(0)};
  EXPECT_EQ(result.stages.occupancy.height(), 64);
}

}  // namespace
}  // namespace stereogrid::test
