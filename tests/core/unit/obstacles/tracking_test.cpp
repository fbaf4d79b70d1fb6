// SPDX-License-Identifier: Apache-2.0
//
// When tracks begin, coast and end.
#include "backend/cpu.hpp"
#include "filter_run.hpp"
#include "painted_obstacles.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

TEST(Tracker, FollowsAMovingBlob) {
  TrackedBlobs run;
  for (int step{0}; step < 25; ++step) {
    // the filter's velocity is unsure at first: it says nothing
    const Point2 velocity{step < 4 ? Point2{} : Point2{1.4, -0.6}};
    run.update({blob_at(0.14 * step, 2 - 0.06 * step, velocity)}, 0.1);
    const std::vector<Obstacle> seen{run.report()};
    ASSERT_EQ(seen.size(), 1u);
    EXPECT_EQ(seen[0].id, 1);
    EXPECT_EQ(seen[0].confirmed, step >= 2) << step;
    EXPECT_NEAR(seen[0].age_s, 0.1 * step, 1e-9);
  }
  const Obstacle last{run.report()[0]};
  EXPECT_NEAR(last.x_m, 0.14 * 24, 0.03);
  EXPECT_NEAR(last.y_m, 2 - 0.06 * 24, 0.03);
  EXPECT_NEAR(last.vx_mps, 1.4, 0.05);
  EXPECT_NEAR(last.vy_mps, -0.6, 0.05);
  EXPECT_TRUE(last.moving);
  EXPECT_FALSE(last.coasting);
  EXPECT_GT(last.velocity_covariance.xx, 0);
  EXPECT_LT(last.velocity_covariance.xx, 1);
}

TEST(Tracker, LargeBlobsAreConfirmedAtOnceIfSure) {
  TrackedBlobs run;
  Cluster large{blob_at(3, 0)};
  large.pixels = 4000;
  Cluster unsure{blob_at(7, -2)};
  unsure.pixels = 4000;
  unsure.is_sure = false;
  for (int step{0}; step < 3; ++step) {
    run.update({large, blob_at(5, 2), unsure}, 0.1);
    const auto expect = [&](std::size_t blob, bool is_certain) {
      EXPECT_EQ(run.report().at(blob).confirmed, is_certain) << blob << ", frame " << step;
      EXPECT_EQ(run.tracker.is_certain(static_cast<std::int64_t>(blob) + 1), is_certain) << blob << ", frame " << step;
    };
    expect(0, true);
    expect(1, step == 2);
    expect(2, false);
  }
  EXPECT_FALSE(run.tracker.is_certain(4));
}

TEST(Tracker, OneFrameConfirmsIfSet) {
  GroundSeenFree world;
  TrackingConfig config{plain_config()};
  config.confirm_frames = 1;
  Tracker tracker{config, PaintedObstacles::rig()};
  update(tracker, world, {blob_at(3, 0)}, 0.1);
  EXPECT_TRUE(report_of(tracker).at(0).confirmed);
}

TEST(Tracker, BlobsBesideTheGridAreNotConfirmed) {
  TrackedBlobs run;
  for (int step{0}; step < 5; ++step) run.update({blob_at(3, 0)}, 0.1);
  const auto is_confirmed = [&](const GridGeometry& grid, const Pose2& vehicle = {}) {
    return report_of(run.tracker, vehicle, grid).at(0).confirmed;
  };
  EXPECT_TRUE(is_confirmed({0, -5, 0.5, 10, 20}));
  EXPECT_TRUE(is_confirmed({0, -5, 0.25, 11, 40})) << "partly inside";
  EXPECT_FALSE(is_confirmed({0, -5, 0.25, 10, 40})) << "ahead of it";
  EXPECT_FALSE(is_confirmed({0, 0.5, 0.5, 10, 20})) << "to the right of it";
  EXPECT_FALSE(is_confirmed({0, -5, 0.5, 10, 20}, {4, 0, 0})) << "behind the vehicle";
}

TEST(Tracker, EndsWhereTheCameraDoesNotLook) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 5; ++step) run.update({blob_at(3, 0), blob_at(1, 3)}, 0.1);
  run.update({}, 0.1);
  ASSERT_EQ(run.report().size(), 1u);
  EXPECT_NEAR(run.report()[0].x_m, 3, 0.1);
}

TEST(Tracker, CoastsWhileUnseenAndTakesUpAgain) {
  TrackedBlobs run{0.5f};
  const auto moving_at = [](double x_m) {
    Cluster blob{blob_at(x_m, 0, {2, 0})};
    blob.velocity_covariance = {0.1, 0, 0.1};
    return blob;
  };
  for (int step{0}; step < 10; ++step) run.update({moving_at(0.2 * step)}, 0.1);
  for (int step{0}; step < 5; ++step) run.update({}, 0.1);
  const std::vector<Obstacle> unseen{run.report()};
  ASSERT_EQ(unseen.size(), 1u);
  EXPECT_NEAR(unseen[0].x_m, 2.8, 0.1);
  EXPECT_NEAR(unseen[0].outline[0].x, 2.5, 0.1) << "its outline goes on with it";
  EXPECT_TRUE(unseen[0].confirmed);
  EXPECT_TRUE(unseen[0].coasting);
  EXPECT_NEAR(unseen[0].unseen_s, 0.5, 1e-9);
  run.update({moving_at(3)}, 0.1);
  const Obstacle again{run.report().at(0)};
  EXPECT_EQ(again.id, 1);
  EXPECT_FALSE(again.coasting);
  EXPECT_LT(again.position_covariance.xx, unseen[0].position_covariance.xx);
}

// Cells that seem to move are no evidence yet.
TEST(Tracker, WhatIsNotSaidToMoveStaysWhileUnseen) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 4; ++step) run.update({blob_at(3, 0, {6, 0})}, 0.1);
  for (int step{0}; step < 5; ++step) run.update({screen()}, 0.1);
  const Obstacle unseen{run.report().at(0)};
  EXPECT_TRUE(unseen.coasting);
  EXPECT_NEAR(unseen.x_m, 3, 1e-9);
  EXPECT_NEAR(unseen.outline[0].x, 2.7, 1e-9);
}

TEST(Tracker, GivesUpAfterCoasting) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 10; ++step) run.update({blob_at(3, 0)}, 0.1);
  for (int step{0}; step < 9; ++step) run.update({screen()}, 0.1);
  EXPECT_EQ(run.report().at(0).id, 1);
  for (int step{0}; step < 2; ++step) run.update({screen()}, 0.1);
  EXPECT_EQ(run.report().at(0).id, 2) << "the screen";
}

TEST(Tracker, WhatStandsAndIsNotSeenThoughNothingHidesItIsOver) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 10; ++step) run.update({blob_at(3, 0)}, 0.1);
  for (int step{0}; step < 2; ++step) run.update({}, 0.1);
  EXPECT_EQ(run.report().size(), 1u) << "two frames may be errors";
  run.update({}, 0.1);
  EXPECT_TRUE(run.report().empty());
}

TEST(Tracker, EndsWhereItsPlaceIsSeenFree) {
  TrackedBlobs run;
  for (int step{0}; step < 10; ++step) run.update({blob_at(3, 0)}, 0.1);
  run.update({}, 0.1);
  EXPECT_EQ(run.report().size(), 1u);  // once may be an error
  for (int step{0}; step < 2; ++step) run.update({}, 0.1);
  EXPECT_TRUE(run.report().empty());
}

TEST(Tracker, AnUnconfirmedGlimpseEndsAtOnce) {
  TrackedBlobs run{0.5f};
  run.update({blob_at(3, 0)}, 0.1);
  run.update({}, 0.1);
  EXPECT_TRUE(run.report().empty());
}

Rig small_rig() {
  return {.width_px = 96, .height_px = 64, .focal_px = 80, .cx_px = 48, .cy_px = 32, .baseline_m = 0.3};
}

// A step in which nothing is seen is what a pipeline predicts: a block at 4 m/s is 2 m further after 0.5 s, one
// that stands is where it was.
TEST(Prediction, MovesWhatMovesAndLeavesWhatStands) {
  constexpr int cells{64};
  constexpr double cell_m{0.2};
  Cpu cpu{2};
  FilterRun run{cpu, method_config(FilterModel::joint), {0, 0, cell_m, cells, cells}};
  for (int step{0}; step < 15; ++step) {
    Image<float> observed{scene(cells, 4 + 2 * step, 20, 5, 5)};
    for (int y{45}; y < 50; ++y) std::fill_n(observed.row(y) + 30, 5, 0.98f);
    run.step(observed);
  }
  run.step(Image<float>(cells, cells, 0.5f), 0.5);
  EXPECT_GT(mean_over(run.layers.occupancy, 32 + 11, 21, 3, 3), 0.7);
  EXPECT_LT(mean_over(run.layers.occupancy, 32, 20, 5, 5), 0.4);
  EXPECT_GT(mean_over(run.layers.occupancy, 30, 45, 5, 5), 0.8);
}

TEST(Prediction, ComesWithEveryFrame) {
  Config config;
  config.grid = {6, 6, 0.2};
  Pipeline pipeline{config, small_rig(), {.threads = 1, .horizons_s = {0.5, 1e4}}};
  Pipeline plain{config, small_rig(), {.threads = 1}};
  std::mt19937 generator{4};
  for (int frame{0}; frame < 3; ++frame) {
    StereoFrame pair;
    pair.name = "f";
    pair.stamp_ns = frame * 100'000'000;
    pair.left = pair.right = noise_image(96, 64, generator);
    const FrameResult& result{pipeline.process(pair)};
    const FrameResult& without{plain.process(pair)};
    ASSERT_EQ(result.predictions.size(), 2u);
    EXPECT_EQ(result.predictions[0].occupancy.width(), result.vehicle.geometry.nx);
    EXPECT_EQ(result.predictions[0].world_occupancy.width(), result.world.geometry.nx);
    // after a very long time nothing is known
    for (const float p : result.predictions[1].occupancy) ASSERT_NEAR(p, 0.5, 0.31);
    // and looking ahead changes nothing
    EXPECT_TRUE(result.vehicle.occupancy == without.vehicle.occupancy);
    EXPECT_TRUE(without.predictions.empty());
  }
}

TEST(Prediction, NeedsHorizonsInTheFuture) {
  for (const double horizon_s : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((Pipeline{Config{}, small_rig(), {.horizons_s = {1, horizon_s}}}), ConfigError) << horizon_s;
  }
}

}  // namespace
}  // namespace stereogrid::test
