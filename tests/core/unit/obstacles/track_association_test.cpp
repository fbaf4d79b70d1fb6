// SPDX-License-Identifier: Apache-2.0
//
// Association of clusters and tracks; merging of tracks.
#include "painted_obstacles.hpp"

namespace stereogrid::test {
namespace {

TEST(Tracker, KeepsTwoApart) {
  TrackedBlobs run;
  for (int step{0}; step < 10; ++step) {
    // in changing order
    std::vector<Cluster> seen{blob_at(1 + 0.2 * step, 0, {2, 0}), blob_at(5, 3)};
    if (step % 2 == 1) std::swap(seen[0], seen[1]);
    run.update(seen, 0.1);
  }
  const std::vector<Obstacle> found{run.report()};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].id, 1);
  EXPECT_NEAR(found[0].x_m, 2.8, 0.2);
  EXPECT_EQ(found[1].id, 2);
  EXPECT_NEAR(found[1].x_m, 5, 0.1);
  EXPECT_NEAR(found[1].vx_mps, 0, 0.1);
}

TEST(Tracker, WhatIsReplacedByAThingThatIsSeenThereIsOver) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 10; ++step) run.update({blob_at(3, 0), blob_at(3.8, 0)}, 0.1);
  EXPECT_EQ(run.report().size(), 2u);
  run.update({blob_at(3.3, 0)}, 0.1);
  EXPECT_EQ(run.report().size(), 1u) << "one of them was seen, the other one is a part of it";
}

Cluster low_object_at(double x, double y, bool is_seen = true) {
  Cluster cluster{blob_at(x, y)};
  cluster.is_low = true;
  cluster.is_seen = is_seen;
  return cluster;
}

TEST(Tracker, MemoryOfALowObjectBesideItDoesNotKeepIt) {
  for (const double beside_m : {0.2, 0.7}) {
    TrackedBlobs run;
    for (int step{0}; step < 10; ++step) run.update({low_object_at(3, 0)}, 0.1);
    for (int step{0}; step < 60; ++step) run.update({low_object_at(3 + beside_m, 0, false)}, 0.1);
    EXPECT_EQ(run.report().size(), beside_m < 0.6 ? 1u : 0u) << "boxes are 0.6 m long";
  }
}

TEST(Tracker, LowObjectsThatBecomeOneAreOne) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 10; ++step) run.update({low_object_at(3, 0), low_object_at(3.7, 0)}, 0.1);
  EXPECT_EQ(run.report().size(), 2u);
  run.update({low_object_at(3.3, 0)}, 0.1);
  EXPECT_EQ(run.report().size(), 1u);
}

// Two things seen as one for a while, said once; both have their ids again where they part, unless one was only known
// for a moment.
TEST(Tracker, IdsLiveThroughMerges) {
  for (const int frames : {5, 15}) {
    TrackedBlobs run{0.5f};
    const Cluster left{blob_at(4, 0.5)};
    const Cluster right{blob_at(4, -0.5)};
    for (int step{0}; step < frames; ++step) run.update({left, right}, 0.1);
    Cluster both{blob_at(4, -0.1)};
    both.outline = {{3.7, 0.7}, {3.7, -0.7}, {4.3, -0.7}, {4.3, 0.7}};
    both.bounds = {{3.7, -0.7}, {4.3, 0.7}};
    for (int step{0}; step < 6; ++step) {
      run.update({both}, 0.1);
      EXPECT_EQ(run.report().size(), 1u);
    }
    run.update({left, right}, 0.1);
    const std::vector<Obstacle> seen{run.report()};
    ASSERT_EQ(seen.size(), 2u);
    for (const Obstacle& obstacle : seen) {
      const int id{obstacle.y_m < 0 ? 2 : frames > 10 ? 1 : 3};
      EXPECT_EQ(obstacle.id, id) << frames;
    }
  }
}

TEST(Bounds, GapIsTheShortestWayBetweenThem) {
  const Bounds one{{0, 0}, {1, 2}};
  const Bounds beyond{{4, 6}, {5, 7}};
  EXPECT_DOUBLE_EQ(one.gap_to(beyond, {}), 5) << "3 m and 4 m";
  EXPECT_DOUBLE_EQ(beyond.gap_to(one, {}), 5);
  EXPECT_DOUBLE_EQ(one.gap_to(beyond, {3, 0}), 4);
  EXPECT_DOUBLE_EQ(one.gap_to(beyond, {0, 4}), 3);
  EXPECT_DOUBLE_EQ(one.gap_to({{0.5, 1}, {9, 9}}, {}), 0) << "they overlap";
}

// Beyond four standard deviations of both velocities it is another thing.
TEST(Tracker, WhatIsSurelyFasterIsAnotherTrack) {
  for (const auto& [sigmas, is_same] : {std::pair{3.0, true}, {5.0, false}}) {
    TrackedBlobs run;
    Cluster blob{blob_at(3, 0)};
    constexpr double sigma_mps{0.3};
    blob.velocity_covariance = {sigma_mps * sigma_mps, 0, sigma_mps * sigma_mps};
    for (int step{0}; step < 40; ++step) run.update({blob}, 0);
    const std::int64_t id{run.report().at(0).id};
    blob.velocity = {sigmas * sigma_mps, 0};
    blob.pixels = 1000;
    run.update({blob}, 0);
    bool is_another{false};
    for (const Obstacle& obstacle : run.report()) is_another = is_another || obstacle.id != id;
    EXPECT_EQ(is_another, !is_same) << sigmas;
  }
}

TEST(Tracker, WhatHasMergedPartsWithinSeventyCentimetres) {
  for (const auto& [away_m, is_same] : {std::pair{0.6, true}, {0.8, false}}) {
    TrackedBlobs run{0.5f};
    const Cluster left{blob_at(4, 0.5)};
    const Cluster right{blob_at(4, -0.5)};
    for (int step{0}; step < 15; ++step) run.update({left, right}, 0.1);
    Cluster both{blob_at(4, -0.1)};
    both.outline = {{3.7, 0.7}, {3.7, -0.7}, {4.3, -0.7}, {4.3, 0.7}};
    both.bounds = {{3.7, -0.7}, {4.3, 0.7}};
    for (int step{0}; step < 3; ++step) run.update({both}, 0.1);
    for (int step{0}; step < 3; ++step) run.update({blob_at(4, 0.5 + away_m), right}, 0.1);
    bool is_first{false};
    for (const Obstacle& obstacle : run.report()) is_first = is_first || (obstacle.y_m > 0 && obstacle.id == 1);
    EXPECT_EQ(is_first, is_same) << away_m;
  }
}

// A track that was a part of another object takes no cluster from an observed track.
TEST(Tracker, WhatHasMergedGetsOnlyWhatIsLeft) {
  TrackedBlobs run{0.5f};
  for (int step{0}; step < 15; ++step) run.update({blob_at(4, 0), blob_at(4, 0.5)}, 0.1);
  run.update({blob_at(4, 0.2)}, 0.1);
  const std::int64_t kept{run.report().front().id};
  run.update({blob_at(4, kept == 1 ? 0.5 : 0)}, 0.1);  // at the other one's place
  ASSERT_EQ(run.report().size(), 1u);
  EXPECT_EQ(run.report().front().id, kept);
}

// A cyclist passes a kerb, which is as near to where he is expected as he is; nothing has been followed on it.
TEST(Tracker, AKerbIsNotTheCyclistBeforeIt) {
  TrackedBlobs run{0.5f};
  const auto cyclist_at = [](double x) {
    Cluster cluster{blob_at(x, 1, {5, 0})};
    cluster.velocity_covariance = {0.2, 0, 0.2};
    cluster.height_m = 1.8;
    return cluster;
  };
  for (int step{0}; step < 5; ++step) run.update({cyclist_at(3 + 0.5 * step)}, 0.1);
  Cluster kerb{blob_at(5.4, 0.6)};
  kerb.height_m = 0.4;
  Cluster late{cyclist_at(5.5 - 0.55)};
  run.update({kerb, late}, 0.1);
  for (const Obstacle& obstacle : run.report()) EXPECT_EQ(obstacle.id == 1, obstacle.height_m > 1);
}

// Two halves of a thing become one: no obstacle is left behind in it, unless it moves and may be hidden.
TEST(Tracker, APartThatIsSeenAsAnotherThingEnds) {
  for (const bool moves : {false, true}) {
    TrackedBlobs run{0.5f};
    Cluster part{blob_at(4, 0.5, {0, moves ? 3.0 : 0.0})};
    if (moves) part.velocity_covariance = {0.1, 0, 0.1};
    for (int step{0}; step < 5; ++step) run.update({blob_at(4, -0.5), part}, 0.01);
    Cluster whole{blob_at(4, -0.4)};
    for (Point2& point : whole.outline) point = {4 + 2 * (point.x - 4), -0.4 + 8 * (point.y + 0.4)};
    whole.bounds = {{3.4, -2}, {4.6, 1.2}};
    run.update({whole}, 0.01);
    EXPECT_EQ(run.report().size(), moves ? 2u : 1u);
  }
}

TEST(Tracker, NeverUsesAnIdTwice) {
  TrackedBlobs run;
  for (int life{0}; life < 3; ++life) {
    for (int step{0}; step < 5; ++step) run.update({blob_at(3, 0)}, 0.1);
    ASSERT_EQ(run.report().size(), 1u);
    EXPECT_EQ(run.report()[0].id, 1 + life);
    for (int step{0}; step < 12; ++step) run.update({}, 0.1);
    ASSERT_TRUE(run.report().empty());
  }
}

TEST(Tracker, FarAwayIsAnotherThing) {
  TrackedBlobs run;
  for (int step{0}; step < 5; ++step) run.update({blob_at(1, 0)}, 0.1);
  run.update({blob_at(4, 0)}, 0.1);
  std::vector<Obstacle> found{run.report()};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[1].id, 2);
  EXPECT_NEAR(found[0].x_m, 1, 0.05);
}

// 5 m/s along a circle of 10 m around (12, 0), against the clock.
// A car that drives ahead has been seen whole; then its rear only, and something alike within it.
TEST(Tracker, WhatMovesWithinAMoverAndAlikeIsAPieceOfIt) {
  const GroundSeenFree world{wide_world()};
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

}  // namespace
}  // namespace stereogrid::test
