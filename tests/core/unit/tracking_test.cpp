// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "obstacles/tracking.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

TrackingConfig plain_config() {
  TrackingConfig config;
  config.gate_m = 1.5;
  config.confirm_frames = 3;
  config.coast_s = 1.0;
  config.acceleration_mps2 = 3;
  return config;
}

// A filtered grid of 60 × 50 cells of 0.2 m, from (−2, −5), all free.
struct World {
  World() {
    layers.geometry = {-2, -5, 0.2, 60, 50};
    layers.occupancy = Image<float>{60, 50, 0.1f};
    layers.age_s = Image<float>{60, 50, 0.0f};
  }

  GridLayers layers;
};

void update(Tracker& tracker, const World& world, const std::vector<Cluster>& clusters, double dt_s) {
  tracker.update(world.layers, clusters, {}, dt_s);
}

Cluster blob_at(double x, double y, Point2 velocity = {}) {
  Cluster cluster;
  cluster.pixels = 60;
  cluster.centre = {x, y};
  cluster.velocity = velocity;
  cluster.occupancy = 0.9;
  cluster.length_m = 0.6;
  cluster.width_m = 0.4;
  for (const Point2 corner : {Point2{-0.3, 0.2}, {-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}}) {
    cluster.outline.push_back({x + corner.x, y + corner.y});
  }
  cluster.bounds = {{x - 0.3, y - 0.2}, {x + 0.3, y + 0.2}};
  return cluster;
}

/// Hides what is seen ahead.
Cluster screen() {
  Cluster cluster{blob_at(1, 0)};
  cluster.outline = {{0.9, 1}, {0.9, -1}, {1.1, -1}, {1.1, 1}};
  cluster.bounds = {{0.9, -1}, {1.1, 1}};
  return cluster;
}

std::vector<Obstacle> report_of(const Tracker& tracker, const Pose2& world_from_vehicle = {}) {
  std::vector<Obstacle> obstacles(2);
  tracker.report(world_from_vehicle, obstacles);
  return obstacles;
}

TEST(Tracker, FollowsAMovingBlob) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 25; ++step) {
    // the filter's velocity is unsure at first: it says nothing
    const Point2 velocity{step < 4 ? Point2{} : Point2{1.4, -0.6}};
    update(tracker, world, {blob_at(0.14 * step, 2 - 0.06 * step, velocity)}, 0.1);
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

// What is seen of a thing changes, and its middle with it: places alone are no motion.
TEST(Tracker, PlacesAloneAreNoMotion) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 25; ++step) update(tracker, world, {blob_at(0.14 * step, 2 - 0.06 * step)}, 0.1);
  const Obstacle last{report_of(tracker)[0]};
  EXPECT_EQ(last.vx_mps, 0);
  EXPECT_FALSE(last.moving);
  EXPECT_NEAR(last.x_m, 0.14 * 24, 0.4) << "it is followed nevertheless";
}

TEST(Tracker, MotionTakesSeveralFramesOfEvidence) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  Cluster blob{blob_at(3, 0, {5, 0})};
  blob.velocity_covariance = {0.16, 0, 0.16};
  for (int step{0}; step < 2; ++step) {
    update(tracker, world, {blob}, 0);
    EXPECT_FALSE(report_of(tracker)[0].moving) << step;
  }
  for (int step{0}; step < 4; ++step) update(tracker, world, {blob}, 0);
  EXPECT_TRUE(report_of(tracker)[0].moving);
  blob.kind = ObstacleKind::extended;
  for (int step{0}; step < 4; ++step) update(tracker, world, {blob}, 0);
  EXPECT_FALSE(report_of(tracker)[0].moving) << "walls do not move";
  EXPECT_EQ(report_of(tracker)[0].kind, ObstacleKind::extended);
}

// The filter has followed its cells before there was a thing.
TEST(Tracker, WhatTheFilterHasSeenMovingNeedsLessEvidence) {
  for (const double share : {0.0, 1.0}) {
    World world;
    Tracker tracker{plain_config(), PaintedObstacles::rig()};
    for (int step{0}; step < 3; ++step) {
      Cluster blob{blob_at(3 + 0.2 * step, 0, {2, 0})};
      blob.velocity_covariance = {0.1, 0, 0.1};
      blob.moving = share;
      update(tracker, world, {blob}, 0.1);
      EXPECT_EQ(report_of(tracker).front().moving, step >= (share > 0.5 ? 1 : 2)) << step;
    }
  }
}

// At the image's border other parts of what stands come into view, or go.
TEST(Tracker, SlowMotionOfWhatIsCutOffNeedsMoreEvidence) {
  for (const bool is_cut : {false, true}) {
    for (const double speed_mps : {1.5, 4.0}) {
      World world;
      Tracker tracker{plain_config(), PaintedObstacles::rig()};
      for (int step{0}; step < 5; ++step) {
        Cluster blob{blob_at(3 + 0.1 * speed_mps * step, 0, {speed_mps, 0})};
        blob.velocity_covariance = {0.1, 0, 0.1};
        blob.is_cut_right = is_cut;
        update(tracker, world, {blob}, 0.1);
        EXPECT_EQ(report_of(tracker).front().moving, step >= (is_cut && speed_mps < 2 ? 4 : 2)) << step;
      }
    }
  }
}

TEST(Tracker, WhatIsSeenLargeIsConfirmedAtOnce) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  Cluster large{blob_at(3, 0)};
  large.pixels = 400;
  update(tracker, world, {large, blob_at(5, 2)}, 0.1);
  EXPECT_TRUE(report_of(tracker).at(0).confirmed);
  EXPECT_FALSE(report_of(tracker).at(1).confirmed);
}

TEST(Tracker, EndsWhereTheCameraDoesNotLook) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 5; ++step) update(tracker, world, {blob_at(3, 0), blob_at(1, 3)}, 0.1);
  update(tracker, world, {}, 0.1);
  ASSERT_EQ(report_of(tracker).size(), 1u);
  EXPECT_NEAR(report_of(tracker)[0].x_m, 3, 0.1);
}

TEST(Tracker, KeepsTwoApart) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) {
    // handed over in changing order
    std::vector<Cluster> seen{blob_at(1 + 0.2 * step, 0, {2, 0}), blob_at(5, 3)};
    if (step % 2 == 1) std::swap(seen[0], seen[1]);
    update(tracker, world, seen, 0.1);
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
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  const auto moving_at = [](double x_m) {
    Cluster blob{blob_at(x_m, 0, {2, 0})};
    blob.velocity_covariance = {0.1, 0, 0.1};
    return blob;
  };
  for (int step{0}; step < 10; ++step) update(tracker, world, {moving_at(0.2 * step)}, 0.1);
  for (int step{0}; step < 5; ++step) update(tracker, world, {}, 0.1);
  const std::vector<Obstacle> unseen{report_of(tracker)};
  ASSERT_EQ(unseen.size(), 1u);
  EXPECT_NEAR(unseen[0].x_m, 2.8, 0.1);
  EXPECT_NEAR(unseen[0].outline[0].x, 2.5, 0.1) << "its outline goes on with it";
  EXPECT_TRUE(unseen[0].confirmed);
  EXPECT_TRUE(unseen[0].coasting);
  EXPECT_NEAR(unseen[0].unseen_s, 0.5, 1e-9);
  update(tracker, world, {moving_at(3)}, 0.1);
  const Obstacle again{report_of(tracker).at(0)};
  EXPECT_EQ(again.id, 1);
  EXPECT_FALSE(again.coasting);
  EXPECT_LT(again.position_covariance.xx, unseen[0].position_covariance.xx);
}

// Cells that seem to move are no evidence yet.
TEST(Tracker, WhatIsNotSaidToMoveStaysWhileUnseen) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 4; ++step) update(tracker, world, {blob_at(3, 0, {6, 0})}, 0.1);
  for (int step{0}; step < 5; ++step) update(tracker, world, {screen()}, 0.1);
  const Obstacle unseen{report_of(tracker).at(0)};
  EXPECT_TRUE(unseen.coasting);
  EXPECT_NEAR(unseen.x_m, 3, 1e-9);
  EXPECT_NEAR(unseen.outline[0].x, 2.7, 1e-9);
}

TEST(Tracker, GivesUpAfterCoasting) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) update(tracker, world, {blob_at(3, 0)}, 0.1);
  for (int step{0}; step < 9; ++step) update(tracker, world, {screen()}, 0.1);
  EXPECT_EQ(report_of(tracker).at(0).id, 1);
  for (int step{0}; step < 2; ++step) update(tracker, world, {screen()}, 0.1);
  EXPECT_EQ(report_of(tracker).at(0).id, 2) << "the screen";
}

TEST(Tracker, WhatStandsAndIsNotSeenThoughNothingHidesItIsOver) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) update(tracker, world, {blob_at(3, 0)}, 0.1);
  for (int step{0}; step < 2; ++step) update(tracker, world, {}, 0.1);
  EXPECT_EQ(report_of(tracker).size(), 1u) << "two frames may be errors";
  update(tracker, world, {}, 0.1);
  EXPECT_TRUE(report_of(tracker).empty());
}

TEST(Tracker, WhatIsReplacedByAThingThatIsSeenThereIsOver) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) update(tracker, world, {blob_at(3, 0), blob_at(3.8, 0)}, 0.1);
  EXPECT_EQ(report_of(tracker).size(), 2u);
  update(tracker, world, {blob_at(3.3, 0)}, 0.1);
  EXPECT_EQ(report_of(tracker).size(), 1u) << "one of them was seen, the other one is a part of it";
}

// Two things seen as one for a while, said once; both have their ids again where they part, unless one was only known
// for a moment.
TEST(Tracker, IdsLiveThroughMerges) {
  for (const int frames : {5, 15}) {
    World world;
    world.layers.occupancy.fill(0.5f);
    Tracker tracker{plain_config(), PaintedObstacles::rig()};
    const Cluster left{blob_at(4, 0.5)};
    const Cluster right{blob_at(4, -0.5)};
    for (int step{0}; step < frames; ++step) update(tracker, world, {left, right}, 0.1);
    Cluster both{blob_at(4, -0.1)};
    both.outline = {{3.7, 0.7}, {3.7, -0.7}, {4.3, -0.7}, {4.3, 0.7}};
    both.bounds = {{3.7, -0.7}, {4.3, 0.7}};
    for (int step{0}; step < 6; ++step) {
      update(tracker, world, {both}, 0.1);
      EXPECT_EQ(report_of(tracker).size(), 1u);
    }
    update(tracker, world, {left, right}, 0.1);
    const std::vector<Obstacle> seen{report_of(tracker)};
    ASSERT_EQ(seen.size(), 2u);
    for (const Obstacle& obstacle : seen) {
      const int id{obstacle.y_m < 0 ? 2 : frames > 10 ? 1 : 3};
      EXPECT_EQ(obstacle.id, id) << frames;
    }
  }
}

// What was a part of another thing takes nothing from a track that is seen.
TEST(Tracker, WhatHasMergedGetsOnlyWhatIsLeft) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 15; ++step) update(tracker, world, {blob_at(4, 0), blob_at(4, 0.5)}, 0.1);
  update(tracker, world, {blob_at(4, 0.2)}, 0.1);
  const std::int64_t kept{report_of(tracker).front().id};
  update(tracker, world, {blob_at(4, kept == 1 ? 0.5 : 0)}, 0.1);  // where the other one was
  ASSERT_EQ(report_of(tracker).size(), 1u);
  EXPECT_EQ(report_of(tracker).front().id, kept);
}

// A cyclist passes a kerb, which is as near to where he is expected as he is; nothing has been followed on it.
TEST(Tracker, AKerbIsNotTheCyclistBeforeIt) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  const auto cyclist_at = [](double x) {
    Cluster cluster{blob_at(x, 1, {5, 0})};
    cluster.velocity_covariance = {0.2, 0, 0.2};
    cluster.height_m = 1.8;
    return cluster;
  };
  for (int step{0}; step < 5; ++step) update(tracker, world, {cyclist_at(3 + 0.5 * step)}, 0.1);
  Cluster kerb{blob_at(5.4, 0.6)};
  kerb.height_m = 0.4;
  Cluster late{cyclist_at(5.5 - 0.55)};
  update(tracker, world, {kerb, late}, 0.1);
  for (const Obstacle& obstacle : report_of(tracker)) EXPECT_EQ(obstacle.id == 1, obstacle.height_m > 1);
}

TEST(Tracker, EndsWhereItsPlaceIsSeenFree) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) update(tracker, world, {blob_at(3, 0)}, 0.1);
  update(tracker, world, {}, 0.1);
  EXPECT_EQ(report_of(tracker).size(), 1u);  // once may be an error
  for (int step{0}; step < 2; ++step) update(tracker, world, {}, 0.1);
  EXPECT_TRUE(report_of(tracker).empty());
}

// Two halves of a thing become one: no obstacle is left behind in it, unless it moves and may be hidden.
TEST(Tracker, APartThatIsSeenAsAnotherThingEnds) {
  for (const bool moves : {false, true}) {
    World world;
    world.layers.occupancy.fill(0.5f);
    Tracker tracker{plain_config(), PaintedObstacles::rig()};
    Cluster part{blob_at(4, 0.5, {0, moves ? 3.0 : 0.0})};
    if (moves) part.velocity_covariance = {0.1, 0, 0.1};
    for (int step{0}; step < 5; ++step) update(tracker, world, {blob_at(4, -0.5), part}, 0.01);
    Cluster whole{blob_at(4, -0.4)};
    for (Point2& point : whole.outline) point = {4 + 2 * (point.x - 4), -0.4 + 8 * (point.y + 0.4)};
    whole.bounds = {{3.4, -2}, {4.6, 1.2}};
    update(tracker, world, {whole}, 0.01);
    EXPECT_EQ(report_of(tracker).size(), moves ? 2u : 1u);
  }
}

TEST(Tracker, AnUnconfirmedGlimpseEndsAtOnce) {
  World world;
  world.layers.occupancy.fill(0.5f);
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  update(tracker, world, {blob_at(3, 0)}, 0.1);
  update(tracker, world, {}, 0.1);
  EXPECT_TRUE(report_of(tracker).empty());
}

TEST(Tracker, NeverUsesAnIdTwice) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int life{0}; life < 3; ++life) {
    for (int step{0}; step < 5; ++step) update(tracker, world, {blob_at(3, 0)}, 0.1);
    ASSERT_EQ(report_of(tracker).size(), 1u);
    EXPECT_EQ(report_of(tracker)[0].id, 1 + life);
    for (int step{0}; step < 12; ++step) update(tracker, world, {}, 0.1);
    ASSERT_TRUE(report_of(tracker).empty());
  }
}

TEST(Tracker, FarAwayIsAnotherThing) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 5; ++step) update(tracker, world, {blob_at(1, 0)}, 0.1);
  update(tracker, world, {blob_at(4, 0)}, 0.1);
  std::vector<Obstacle> found{report_of(tracker)};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[1].id, 2);
  EXPECT_NEAR(found[0].x_m, 1, 0.05);
}

TEST(Tracker, ReportsInTheVehicleFrame) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  Cluster blob{blob_at(4, 3, {2, 1})};
  blob.yaw_rad = 30 * degree;
  blob.velocity_covariance = {0.09, 0, 0.09};
  for (int step{0}; step < 4; ++step) update(tracker, world, {blob}, 0);
  // the car stands at (4, 1) and faces +y: the blob is 2 m ahead, moves to the right and away
  const Obstacle seen{report_of(tracker, {4, 1, 90 * degree}).at(0)};
  EXPECT_NEAR(seen.x_m, 2, 0.01);
  EXPECT_NEAR(seen.y_m, 0, 0.01);
  EXPECT_NEAR(seen.vx_mps, 1, 1e-6);
  EXPECT_NEAR(seen.vy_mps, -2, 1e-6);
  EXPECT_NEAR(seen.yaw_rad, std::atan2(-2, 1), 1e-6) << "its box lies along its motion";
  // around an outline of 0.6 × 0.4 m
  const double c{std::cos(std::atan2(1, 2))};
  const double s{std::sin(std::atan2(1, 2))};
  EXPECT_NEAR(seen.length_m, 0.6 * c + 0.4 * s, 0.03);
  EXPECT_NEAR(seen.width_m, 0.6 * s + 0.4 * c, 0.03);
  EXPECT_NEAR(seen.occupancy, 0.9, 1e-9);
  const Obstacle in_world{report_of(tracker).at(0)};
  ASSERT_EQ(seen.outline.size(), 4u);
  EXPECT_NEAR(seen.outline[0].x, 2.2, 1e-6);
  EXPECT_NEAR(seen.outline[0].y, 0.3, 1e-6);
  EXPECT_NEAR(seen.velocity_covariance.xx, in_world.velocity_covariance.yy, 1e-9);
  EXPECT_NEAR(seen.position_covariance.yy, in_world.position_covariance.xx, 1e-9);
}

/// A box with points followed on it, from its sides along the axes.
Cluster box_between(Point2 least, Point2 most, Point2 velocity, double sigma_mps) {
  Cluster cluster{blob_at((least.x + most.x) / 2, (least.y + most.y) / 2, velocity)};
  cluster.outline = {least, {most.x, least.y}, most, {least.x, most.y}};
  cluster.bounds = {least, most};
  cluster.length_m = most.x - least.x;
  cluster.width_m = most.y - least.y;
  cluster.velocity_covariance = {sigma_mps * sigma_mps, 0, sigma_mps * sigma_mps};
  return cluster;
}

World wide_world() {
  World world;
  world.layers.geometry = {-30, -30, 0.5, 120, 120};
  world.layers.occupancy = Image<float>{120, 120, 0.5f};
  world.layers.age_s = Image<float>{120, 120, 0.0f};
  return world;
}

// From the left, 8 m ahead, at 4 m/s to the right: its front is seen, of its length at first only a part.
TEST(Tracker, WhatComesIntoViewKeepsSpeedAndPlaceOfItsNearSide) {
  const World world{wide_world()};
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) {
    const double front{4.5 - 0.4 * step};
    const double rear{std::min(front + 4, 5.0)};
    Cluster car{box_between({8, front}, {9.5, rear}, {0, -4}, 0.5)};
    car.yaw_rad = -90 * degree;
    std::swap(car.length_m, car.width_m);
    car.is_cut_left = rear == 5;
    update(tracker, world, {car}, 0.1);
    const Obstacle seen{report_of(tracker).at(0)};
    if (step < 3) continue;
    ASSERT_TRUE(seen.moving) << step;
    EXPECT_EQ(seen.id, 1);
    EXPECT_NEAR(seen.vy_mps, -4, 0.15) << "its middle is only half as fast, step " << step;
    EXPECT_NEAR(seen.y_m - seen.length_m / 2, front, 0.1) << step;
    EXPECT_EQ(std::isinf(seen.length_sigma_m), car.is_cut_left) << step;
  }
}

// 5 m/s along a circle of 10 m around (12, 0), against the clock.
// A car that drives ahead has been seen whole; then its rear only, and something alike within it.
TEST(Tracker, WhatMovesWithinAMoverAndAlikeIsAPieceOfIt) {
  const World world{wide_world()};
  for (const double piece_mps : {4.0, 7.0}) {
    Tracker tracker{plain_config(), PaintedObstacles::rig()};
    const auto car = [](int step, double length_m) {
      const double rear{8 + 0.4 * step};
      return box_between({rear, -1}, {rear + length_m, 1}, {4, 0}, 0.3);
    };
    for (int step{0}; step < 5; ++step) update(tracker, world, {car(step, 4)}, 0.1);
    const auto piece = [&](int step) {
      return box_between({11 + 0.4 * step, -0.9}, {11.5 + 0.4 * step, 0.9}, {piece_mps, 0}, 0.3);
    };
    for (int step{5}; step < 9; ++step) update(tracker, world, {car(step, 1), piece(step)}, 0.1);
    const std::vector<Obstacle> both{report_of(tracker)};
    EXPECT_EQ(both.size(), piece_mps == 4 ? 1U : 2U) << "what is faster is another thing";
    EXPECT_EQ(both.front().id, 1);
    update(tracker, world, {piece(9)}, 0.1);  // the rear is hidden
    const std::vector<Obstacle> left{report_of(tracker)};
    EXPECT_EQ(left.size(), piece_mps == 4 ? 1U : 2U);
    for (const Obstacle& obstacle : left) EXPECT_EQ(obstacle.coasting, piece_mps != 4 && obstacle.id == 1);
    EXPECT_EQ(left.front().id, 1);
  }
}

TEST(Tracker, ATurningCarHasAYawRateAndCoastsAlongItsCircle) {
  const World world{wide_world()};
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  const auto angle_at = [](int step) { return -1.2 + 0.05 * step; };
  const auto place_at = [&](int step) {
    return Point2{12 + 10 * std::cos(angle_at(step)), 10 * std::sin(angle_at(step))};
  };
  EXPECT_EQ(Obstacle{}.yaw_rate_radps, 0);
  for (int step{0}; step < 20; ++step) {
    const Point2 at{place_at(step)};
    const Point2 velocity{-5 * std::sin(angle_at(step)), 5 * std::cos(angle_at(step))};
    Cluster car{blob_at(at.x, at.y, velocity)};
    car.velocity_covariance = {0.01, 0, 0.01};
    update(tracker, world, {car}, 0.1);
    EXPECT_TRUE(step >= 2 || report_of(tracker).at(0).yaw_rate_radps == 0) << "not surely yet";
  }
  EXPECT_NEAR(report_of(tracker).at(0).yaw_rate_radps, 0.5, 0.15);
  EXPECT_LT(report_of(tracker).at(0).yaw_sigma_rad, 0.1);
  for (int step{20}; step < 26; ++step) update(tracker, world, {}, 0.1);
  const Obstacle unseen{report_of(tracker).at(0)};
  ASSERT_TRUE(unseen.coasting);
  const Point2 straight{place_at(19).x - 5 * std::sin(angle_at(19)) * 0.6,
                        place_at(19).y + 5 * std::cos(angle_at(19)) * 0.6};
  const double from_circle{std::hypot(unseen.x_m - place_at(25).x, unseen.y_m - place_at(25).y)};
  EXPECT_NEAR(std::hypot(unseen.x_m - 12, unseen.y_m), 10, 0.15) << "it coasts along the circle";
  EXPECT_LT(from_circle, 0.5 * std::hypot(straight.x - place_at(25).x, straight.y - place_at(25).y));
}

TEST(Tracker, WhatStandsHasNoYawRateAndAnUnknownSize) {
  World world;
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 5; ++step) update(tracker, world, {blob_at(3, 0)}, 0.1);
  const Obstacle seen{report_of(tracker).at(0)};
  EXPECT_EQ(seen.yaw_rate_radps, 0);
  EXPECT_TRUE(std::isinf(seen.length_sigma_m));
  EXPECT_TRUE(std::isinf(seen.width_sigma_m));
}

// For a moment only, as a cluster that is followed wrongly does.
TEST(Tracker, WhatIsSaidToMoveByFewFramesStandsWhenItIsNotSeen) {
  const World world{wide_world()};
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  Cluster blob{blob_at(3, 0, {5, 0})};
  blob.velocity_covariance = {0.16, 0, 0.16};
  for (int step{0}; step < 3; ++step) update(tracker, world, {blob}, 0.01);
  EXPECT_TRUE(report_of(tracker).at(0).moving);
  Tracker brief{plain_config(), PaintedObstacles::rig()};
  blob.pixels = 400;
  for (int step{0}; step < 3; ++step) update(brief, world, {blob}, 0.01);
  update(brief, world, {}, 0.005);
  const Obstacle unseen{report_of(brief).at(0)};
  EXPECT_TRUE(unseen.coasting);
  EXPECT_FALSE(unseen.moving);
}

}  // namespace
}  // namespace stereogrid::test
