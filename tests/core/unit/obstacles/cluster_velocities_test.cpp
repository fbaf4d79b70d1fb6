// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "flow_vectors.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

// Two things side by side, 8 m ahead: from y = 1 to 2 m and from −2 to −1 m.
struct TwoClusters {
  TwoClusters() : space{obstacle_space()}, clusters{space.clusters} {
    const PaintedObstacles painted{PaintedObstacles{}.wall(8, 1, 2).wall(8, -2, -1)};
    find_clusters(painted.disparity.view(), {1.2, 0, 0, true}, still_world(), {}, {}, in_one, space);
    clusters.at(0).velocity = clusters.at(1).velocity = {0.5, 0};
    if (space.segmenter.segment_at({8, 1.5}) != 0) std::swap(first, second);
  }

  ClusterWorkspace space;
  std::vector<Cluster>& clusters;
  std::size_t first{0};
  std::size_t second{1};
};

TEST(ClusterVelocities, AreThoseOfTheirPoints) {
  TwoClusters world;
  measure_velocities({vector_at({8, 1.2}, {6, 1}), vector_at({8, 1.4}, {6.2, 1}), vector_at({8, 1.8}, {6.1, 1}),
                      vector_at({8, 1.6}, {-8, 3}), vector_at({8.1, -0.95}, {-2, 0}), vector_at({7.9, -2.05}, {-2, 0})},
                     {}, world.space);
  const Cluster& first{world.clusters[world.first]};
  EXPECT_NEAR(first.velocity.x, 6.1, 0.01) << "without the one that does not fit";
  EXPECT_NEAR(first.velocity.y, 1, 0.01);
  EXPECT_NEAR(world.clusters[world.second].velocity.x, -2, 0.01) << "points beside their cluster";
}

// Features do not average out an error of the ego-motion: here σ is 0.8 m/s of 1.2 m/s.
TEST(ClusterVelocities, ContainTheErrorOfTheEgoMotion) {
  TwoClusters world;
  std::vector<FlowVector> vectors(20, vector_at({8, 1.4}, {1.2, 0}));
  measure_velocities(vectors, {}, world.space);
  const Cluster before{world.clusters[world.first]};
  for (FlowVector& vector : vectors) vector.common_covariance = {0.8 * 0.8, 0, 0};
  measure_velocities(vectors, {}, world.space);
  const Cluster& after{world.clusters[world.first]};
  EXPECT_NEAR(after.velocity_covariance.xx - before.velocity_covariance.xx, 0.8 * 0.8, 1e-9);
  EXPECT_EQ(after.velocity_covariance.yy, before.velocity_covariance.yy);
  EXPECT_GT(squared(inverted(before.velocity_covariance), before.velocity), 4) << "significant without it";
  EXPECT_LT(squared(inverted(after.velocity_covariance), after.velocity), 4);
}

// Along the ray to the first point and across it: lateral velocity is far more accurate.
TEST(ClusterVelocities, AreSurerAcrossTheRay) {
  const double distance_m{std::hypot(8, 1.2)};
  const Point2 ray{8 / distance_m, 1.2 / distance_m};
  for (const int n : {3, 6}) {
    TwoClusters world;
    std::vector<FlowVector> vectors;
    for (int i{0}; i < n; ++i) vectors.push_back(vector_at({8, 1.2 + 0.1 * i}, {6, 1}));
    measure_velocities(vectors, {}, world.space);
    const Symmetric2& covariance{world.clusters[world.first].velocity_covariance};
    const double few{n < 5 ? 0.3 : 0};
    const double drift{0.35 * distance_m * distance_m / 80};
    EXPECT_NEAR(squared(covariance, ray), 0.25 / n * (1 + 0.05 * (n - 1)) + 0.1 * 0.1 + drift * drift + few * few,
                1e-6);
    EXPECT_NEAR(squared(covariance, {-ray.y, ray.x}),
                0.4 * 0.4 * 0.25 / n + 0.06 * 0.06 + 0.01 * 0.01 * distance_m * distance_m + few * few, 1e-6);
    EXPECT_LT(covariance.yy, covariance.xx);
  }
}

TEST(ClusterVelocities, NeedTwoPointsThatAgree) {
  TwoClusters world;
  measure_velocities({vector_at({8, 1.2}, {6, 1}), vector_at({8, 5}, {3, 3})}, {}, world.space);
  for (const Cluster& cluster : world.clusters) {
    EXPECT_EQ(cluster.velocity.x, 0.5);
    EXPECT_FALSE(cluster.has_measured_velocity());
  }
}

TEST(ClusterVelocities, AreNoneWhereAPixelIsWorthMetres) {
  for (const double x_m : {19.0, 21.0}) {
    ClusterWorkspace space{obstacle_space()};
    const std::vector<FlowVector> vectors(5, vector_at({x_m, 0.2}, {6, 0}));
    find_clusters(PaintedObstacles{}.wall(x_m, -1, 1).disparity.view(), {1.2, 0, 0, true}, still_world(), {}, vectors,
                  in_one, space);
    ASSERT_EQ(space.clusters.size(), 1u);
    EXPECT_EQ(space.clusters[0].has_measured_velocity(), x_m < 20) << "4.5 m for a pixel at 19 m, 5.5 m at 21 m";
  }
}

// A car passes a parked one so closely that their disparities touch.
class Passing : public testing::Test {
 protected:
  std::vector<Cluster> found(const std::vector<FlowVector>& vectors) {
    ClusterWorkspace space{obstacle_space()};
    find_clusters(PaintedObstacles{}.wall(8, -2, 2).disparity.view(), {1.2, 0, 0, true}, still_world(), {}, vectors,
                  in_one, space);
    return space.clusters;
  }
  // `left`: the velocity of the points of the left half; the others stand.
  static std::vector<FlowVector> half_moving(Point2 left, int points = 5) {
    std::vector<FlowVector> vectors;
    for (int i{0}; i < points; ++i) {
      vectors.push_back(vector_at({8, 0.2 + 0.4 * i}, left, 0.8));
      vectors.push_back(vector_at({8, -0.2 - 0.4 * i}, {0.3, 0}, 0.8));
    }
    return vectors;
  }
};

TEST_F(Passing, IsAThingOfItsOwn) {
  const std::vector<Cluster> clusters{found(half_moving({-8, 0}))};
  ASSERT_EQ(clusters.size(), 2u);
  EXPECT_NEAR(clusters[0].velocity.x, 0.3, 1e-6);
  EXPECT_NEAR(clusters[1].velocity.x, -8, 1e-6);
  EXPECT_NEAR(clusters[0].centre.y, -1, 0.2);
  EXPECT_NEAR(clusters[1].centre.y, 1, 0.2);
}

// Errors of the poses are those of all points.
TEST_F(Passing, PrecisePointsStandWithinTheErrorOfThePoses) {
  std::vector<FlowVector> vectors{half_moving({-8, 0})};
  for (FlowVector& vector : vectors) {
    if (vector.velocity.x > 0) vector = vector_at(vector.place, {0.45, 0}, 0.05);
  }
  EXPECT_EQ(found(vectors).size(), 2u);
}

TEST_F(Passing, NeedsPointsThatSurelyMoveAlikeAndTogether) {
  EXPECT_EQ(found(half_moving({-1, 0})).size(), 1u) << "too slow to be sure";
  EXPECT_EQ(found(half_moving({-8, 0}, 2)).size(), 1u) << "too few";
  std::vector<FlowVector> mixed;
  for (int i{0}; i < 10; ++i) {
    mixed.push_back(vector_at({8, -1.8 + 0.4 * i}, i % 2 == 0 ? Point2{-8, 0} : Point2{}, 0.8));
  }
  EXPECT_EQ(found(mixed).size(), 1u) << "one beside the other";
  std::vector<FlowVector> wild{half_moving({-8, 0})};
  for (std::size_t i{0}; i < wild.size(); i += 2)
    wild[i].velocity = {static_cast<double>(2 * i) - 8, static_cast<double>(4 * i)};
  EXPECT_EQ(found(wild).size(), 1u) << "each another way";
}

TEST(ClusterVelocities, OfPointsReachATrackSoon) {
  TrackingConfig config;
  config.confirm_frames = 1;
  GridLayers world;
  world.geometry = {-4, -4, 0.2, 40, 40};
  world.occupancy = world.age_s = Image<float>{40, 40};
  const auto speed_of = [&](double sigma_mps) {
    Tracker tracker{config, PaintedObstacles::rig()};
    Cluster cluster;
    cluster.centre = {0, 0};
    cluster.length_m = cluster.width_m = 0.5;
    tracker.update(world, {cluster}, {}, 0.1);
    cluster.velocity = {3, 0};
    cluster.velocity_covariance = {sigma_mps * sigma_mps, 0, sigma_mps * sigma_mps};
    for (int frame{0}; frame < 3; ++frame) tracker.update(world, {cluster}, {}, 0.1);
    std::vector<Obstacle> obstacles;
    tracker.report({}, {-50, -50, 1, 100, 100}, obstacles);
    return obstacles.at(0).vx_mps;
  };
  EXPECT_GT(speed_of(0.4), 2.2);
  EXPECT_LT(speed_of(0), 2) << "of cells, at the same place";
}

}  // namespace
}  // namespace stereogrid::test
