// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "obstacles/tracking.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support.hpp"

namespace stereogrid::test {
namespace {

TrackingConfig plain_config() {
  TrackingConfig config;
  config.occupancy_min = 0.65;
  config.cells_min = 3;
  config.gate_m = 1.5;
  config.confirm_frames = 3;
  config.coast_s = 1.0;
  config.acceleration_mps2 = 3;
  return config;
}

// A filtered grid of 60 × 50 cells of 0.2 m, from (−2, −5), that can be painted.
struct World {
  World() {
    layers.geometry = {-2, -5, 0.2, 60, 50};
    layers.occupancy = Image<float>{60, 50, 0.1f};
    layers.velocity_x = layers.velocity_y = layers.moving = Image<float>{60, 50};
    layers.age_s = Image<float>{60, 50, 0.0f};
  }

  // Cells [x, x + nx) × [y, y + ny).
  World& paint(int x, int y, int nx, int ny, float occupancy, Point2 velocity = {}) {
    for (int iy{y}; iy < y + ny; ++iy) {
      for (int ix{x}; ix < x + nx; ++ix) {
        layers.occupancy(ix, iy) = occupancy;
        layers.velocity_x(ix, iy) = static_cast<float>(velocity.x);
        layers.velocity_y(ix, iy) = static_cast<float>(velocity.y);
        layers.moving(ix, iy) = velocity.x != 0 || velocity.y != 0 ? occupancy : 0.0f;
      }
    }
    return *this;
  }

  std::vector<Cluster> clusters(const TrackingConfig& config = plain_config()) {
    ClusterSpace space{60, 50};
    space.labels.fill(9);
    space.clusters.resize(4);
    find_clusters(layers, config, space);
    labels = space.labels;
    return space.clusters;
  }

  GridLayers layers;
  Image<int> labels;
};

TEST(Clusters, TouchingCellsAreOne) {
  World world;
  // a 4 × 2 block, another that touches it at a corner, and a third apart
  world.paint(10, 10, 4, 2, 0.9f).paint(14, 12, 3, 1, 0.8f).paint(30, 20, 2, 2, 0.7f);
  const std::vector<Cluster> found{world.clusters()};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].cells, 11);
  EXPECT_NEAR(found[0].occupancy, (8 * 0.9 + 3 * 0.8) / 11, 1e-6);
  EXPECT_EQ(found[1].cells, 4);
  // cell (30, 20) begins at x = −2 + 6, y = −5 + 4
  EXPECT_NEAR(found[1].centre.x, 4.2, 1e-9);
  EXPECT_NEAR(found[1].centre.y, -0.8, 1e-9);
  EXPECT_NEAR(found[1].length_m, 0.4, 1e-9);
  EXPECT_NEAR(found[1].width_m, 0.4, 1e-9);
  EXPECT_EQ(world.labels(10, 10), 1);
  EXPECT_EQ(world.labels(16, 12), 1);
  EXPECT_EQ(world.labels(31, 21), 2);
  EXPECT_EQ(world.labels(20, 20), 0);
}

TEST(Clusters, SmallOnesAreIgnored) {
  World world;
  world.paint(10, 10, 2, 1, 0.9f).paint(20, 10, 3, 1, 0.9f);
  const std::vector<Cluster> found{world.clusters()};
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].cells, 3);
  EXPECT_EQ(world.labels(10, 10), 0);
  EXPECT_EQ(world.labels(20, 10), 1);
}

TEST(Clusters, VelocityTellsNeighboursApart) {
  World world;
  world.paint(10, 10, 4, 4, 0.9f, {0, 0}).paint(14, 10, 4, 4, 0.9f, {0, -4});
  const std::vector<Cluster> found{world.clusters()};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].velocity.y, 0, 1e-6);
  EXPECT_NEAR(found[1].velocity.y, -4, 1e-6);
  EXPECT_NEAR(found[1].yaw_rad, -90 * degree, 1e-6);
}

TEST(Clusters, CellsBelowTheThresholdOrNeverSeenDoNotCount) {
  World world;
  world.paint(10, 10, 4, 4, 0.6f).paint(20, 10, 4, 4, 0.9f);
  for (int y{10}; y < 14; ++y) {
    for (int x{20}; x < 24; ++x) world.layers.age_s(x, y) = std::numeric_limits<float>::infinity();
  }
  EXPECT_TRUE(world.clusters().empty());
}

TEST(Clusters, BoxLiesAlongTheLongerSideOrTheMotion) {
  World world;
  world.paint(10, 10, 2, 9, 0.9f);
  const std::vector<Cluster> still{world.clusters()};
  ASSERT_EQ(still.size(), 1u);
  EXPECT_NEAR(std::abs(still[0].yaw_rad), 90 * degree, 1e-6);
  EXPECT_NEAR(still[0].length_m, 1.8, 1e-6);
  EXPECT_NEAR(still[0].width_m, 0.4, 1e-6);
  world.paint(10, 10, 2, 9, 0.9f, {2, 0});
  const std::vector<Cluster> moving{world.clusters()};
  EXPECT_NEAR(moving.at(0).yaw_rad, 0, 1e-6);
  EXPECT_NEAR(moving.at(0).length_m, 0.4, 1e-6);
  EXPECT_NEAR(moving.at(0).width_m, 1.8, 1e-6);
}

TEST(Clusters, FrameOfTheGridIsNoProblem) {
  World world;
  world.paint(0, 0, 60, 50, 0.9f);
  ASSERT_EQ(world.clusters().size(), 1u);
  EXPECT_EQ(world.clusters()[0].cells, 3000);
}

Cluster blob_at(double x, double y, Point2 velocity = {}) {
  Cluster cluster;
  cluster.cells = 6;
  cluster.centre = {x, y};
  cluster.velocity = velocity;
  cluster.occupancy = 0.9;
  cluster.length_m = 0.6;
  cluster.width_m = 0.4;
  return cluster;
}

std::vector<Obstacle> report_of(const Tracker& tracker, const Pose2& world_from_vehicle = {}) {
  std::vector<Obstacle> obstacles(2);
  tracker.report(world_from_vehicle, obstacles);
  return obstacles;
}

TEST(Tracker, FollowsAMovingBlob) {
  World world;
  Tracker tracker{plain_config()};
  for (int step{0}; step < 25; ++step) {
    // the filter's velocity is unsure at first: it says nothing
    const Point2 velocity{step < 4 ? Point2{} : Point2{1.4, -0.6}};
    tracker.update(world.layers, {blob_at(0.14 * step, 2 - 0.06 * step, velocity)}, 0.1);
    const std::vector<Obstacle> seen{report_of(tracker)};
    ASSERT_EQ(seen.size(), 1u);
    EXPECT_EQ(seen[0].id, 1);
    EXPECT_EQ(seen[0].confirmed, step >= 2) << step;
    EXPECT_NEAR(seen[0].age_s, 0.1 * step, 1e-9);
  }
  const Obstacle last{report_of(tracker)[0]};
  EXPECT_NEAR(last.x_m, 0.14 * 24, 0.03);
  EXPECT_NEAR(last.y_m, 2 - 0.06 * 24, 0.03);
  EXPECT_NEAR(last.vx_mps, 1.4, 0.05);
  EXPECT_NEAR(last.vy_mps, -0.6, 0.05);
  EXPECT_TRUE(last.moving);
  EXPECT_FALSE(last.coasting);
  EXPECT_GT(last.velocity_covariance.xx, 0);
  EXPECT_LT(last.velocity_covariance.xx, 1);
}

// The clusters say that they stand, their places that they move: places count.
TEST(Tracker, MeasuresVelocityFromPlacesToo) {
  World world;
  Tracker tracker{plain_config()};
  for (int step{0}; step < 25; ++step) {
    tracker.update(world.layers, {blob_at(0.14 * step, 2 - 0.06 * step)}, 0.1);
  }
  const Obstacle last{report_of(tracker)[0]};
  EXPECT_GT(last.vx_mps, 0.4);
  EXPECT_LT(last.vx_mps, 1.4);
  EXPECT_LT(last.vy_mps, -0.15);
}

TEST(Tracker, KeepsTwoApart) {
  World world;
  Tracker tracker{plain_config()};
  for (int step{0}; step < 10; ++step) {
    // handed over in changing order
    std::vector<Cluster> seen{blob_at(1 + 0.2 * step, 0, {2, 0}), blob_at(5, 3)};
    if (step % 2 == 1) std::swap(seen[0], seen[1]);
    tracker.update(world.layers, seen, 0.1);
  }
  const std::vector<Obstacle> found{report_of(tracker)};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].id, 1);
  EXPECT_NEAR(found[0].x_m, 2.8, 0.2);
  EXPECT_EQ(found[1].id, 2);
  EXPECT_NEAR(found[1].x_m, 5, 0.1);
  EXPECT_NEAR(found[1].vx_mps, 0, 0.1);
}

TEST(Tracker, CoastsWhileUnseenAndTakesUpAgain) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config()};
  for (int step{0}; step < 10; ++step) tracker.update(world.layers, {blob_at(0.1 * step, 0, {1, 0})}, 0.1);
  for (int step{0}; step < 5; ++step) tracker.update(world.layers, {}, 0.1);
  const std::vector<Obstacle> unseen{report_of(tracker)};
  ASSERT_EQ(unseen.size(), 1u);
  EXPECT_NEAR(unseen[0].x_m, 1.4, 0.1);
  EXPECT_TRUE(unseen[0].confirmed);
  EXPECT_TRUE(unseen[0].coasting);
  EXPECT_NEAR(unseen[0].unseen_s, 0.5, 1e-9);
  tracker.update(world.layers, {blob_at(1.5, 0, {1, 0})}, 0.1);
  const Obstacle again{report_of(tracker).at(0)};
  EXPECT_EQ(again.id, 1);
  EXPECT_FALSE(again.coasting);
  EXPECT_LT(again.position_covariance.xx, unseen[0].position_covariance.xx);
}

TEST(Tracker, GivesUpAfterCoasting) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config()};
  for (int step{0}; step < 10; ++step) tracker.update(world.layers, {blob_at(3, 0)}, 0.1);
  for (int step{0}; step < 9; ++step) tracker.update(world.layers, {}, 0.1);
  EXPECT_EQ(report_of(tracker).size(), 1u);
  for (int step{0}; step < 2; ++step) tracker.update(world.layers, {}, 0.1);
  EXPECT_TRUE(report_of(tracker).empty());
}

TEST(Tracker, EndsWhereItsPlaceIsSeenFree) {
  World world;
  Tracker tracker{plain_config()};
  for (int step{0}; step < 10; ++step) tracker.update(world.layers, {blob_at(3, 0)}, 0.1);
  tracker.update(world.layers, {}, 0.1);
  EXPECT_EQ(report_of(tracker).size(), 1u);  // once may be an error
  for (int step{0}; step < 2; ++step) tracker.update(world.layers, {}, 0.1);
  EXPECT_TRUE(report_of(tracker).empty());
}

TEST(Tracker, AnUnconfirmedGlimpseEndsAtOnce) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config()};
  tracker.update(world.layers, {blob_at(3, 0)}, 0.1);
  tracker.update(world.layers, {}, 0.1);
  EXPECT_TRUE(report_of(tracker).empty());
}

TEST(Tracker, NeverUsesAnIdTwice) {
  World world;
  Tracker tracker{plain_config()};
  for (int life{0}; life < 3; ++life) {
    for (int step{0}; step < 5; ++step) tracker.update(world.layers, {blob_at(3, 0)}, 0.1);
    ASSERT_EQ(report_of(tracker).size(), 1u);
    EXPECT_EQ(report_of(tracker)[0].id, 1 + life);
    for (int step{0}; step < 12; ++step) tracker.update(world.layers, {}, 0.1);
    ASSERT_TRUE(report_of(tracker).empty());
  }
}

TEST(Tracker, FarAwayIsAnotherThing) {
  World world;
  Tracker tracker{plain_config()};
  for (int step{0}; step < 5; ++step) tracker.update(world.layers, {blob_at(1, 0)}, 0.1);
  tracker.update(world.layers, {blob_at(4, 0)}, 0.1);
  std::vector<Obstacle> found{report_of(tracker)};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[1].id, 2);
  EXPECT_NEAR(found[0].x_m, 1, 0.05);
}

TEST(Tracker, ReportsInTheVehicleFrame) {
  World world;
  Tracker tracker{plain_config()};
  Cluster blob{blob_at(4, 3, {2, 1})};
  blob.yaw_rad = 30 * degree;
  for (int step{0}; step < 4; ++step) tracker.update(world.layers, {blob}, 0);
  // the car stands at (4, 1) and faces +y: the blob is 2 m ahead, moves to the right and away
  const Obstacle seen{report_of(tracker, {4, 1, 90 * degree}).at(0)};
  EXPECT_NEAR(seen.x_m, 2, 1e-6);
  EXPECT_NEAR(seen.y_m, 0, 1e-6);
  EXPECT_NEAR(seen.vx_mps, 1, 1e-6);
  EXPECT_NEAR(seen.vy_mps, -2, 1e-6);
  EXPECT_NEAR(seen.yaw_rad, -60 * degree, 1e-6);
  EXPECT_NEAR(seen.length_m, 0.6, 1e-9);
  EXPECT_NEAR(seen.width_m, 0.4, 1e-9);
  EXPECT_NEAR(seen.occupancy, 0.9, 1e-9);
  const Obstacle in_world{report_of(tracker).at(0)};
  EXPECT_NEAR(seen.velocity_covariance.xx, in_world.velocity_covariance.yy, 1e-9);
  EXPECT_NEAR(seen.position_covariance.yy, in_world.position_covariance.xx, 1e-9);
}

}  // namespace
}  // namespace stereogrid::test
