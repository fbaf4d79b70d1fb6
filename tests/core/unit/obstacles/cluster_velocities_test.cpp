// SPDX-License-Identifier: Apache-2.0
#include "motion/velocity_evidence.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

// Two things side by side, 8 m ahead: from y = 1 to 2 m and from −2 to −1 m.
struct TwoClusters {
  TwoClusters() : space{obstacle_space()}, clusters{space.clusters} {
    const PaintedObstacles painted{PaintedObstacles{}.wall(8, 1, 2).wall(8, -2, -1)};
    find_clusters(painted.disparity.view(), {1.2, 0, 0, true}, still_world(), {}, {}, space);
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
                  space);
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
                  space);
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

constexpr GridGeometry window{-4, -4, 0.2, 40, 40};

// Velocities up to 8 m/s in steps without effect.
std::vector<double> continuous_axis() {
  std::vector<double> axis_mps;
  for (int i{-20000}; i <= 20000; ++i) axis_mps.push_back(0.0004 * i);
  return axis_mps;
}

TEST(EvidenceMap, CoversTheCellsAroundAPoint) {
  EvidenceMap map{40, continuous_axis()};
  const std::vector<VelocityEvidence> evidence{map.gather({vector_at({0.1, 0.1}, {2, -1})}, window, in_one)};
  ASSERT_GT(evidence.size(), 9u);
  EXPECT_TRUE(std::is_sorted(evidence.begin(), evidence.end(),
                             [](const VelocityEvidence& a, const VelocityEvidence& b) { return a.cell < b.cell; }));
  float most{0};
  int surest{-1};
  for (const VelocityEvidence& one : evidence) {
    EXPECT_NEAR(one.x, 2, 1e-5);
    EXPECT_NEAR(one.y, -1, 1e-5);
    if (one.xx > most) surest = one.cell;
    most = std::max(most, one.xx);
    const double away_m{std::hypot(one.cell % 40 - 20, one.cell / 40 - 20) * 0.2};
    EXPECT_LT(away_m, 0.8);
  }
  EXPECT_EQ(surest, 20 * 40 + 20) << "the point's own cell";
  EXPECT_TRUE(map.gather({}, window, in_one).empty()) << "nothing is left of the frame before";
}

// Points share errors: twenty of them count as four.
TEST(EvidenceMap, InformationOfManyPointsIsBounded) {
  EvidenceMap map{40, continuous_axis()};
  const auto information_of = [&](std::size_t points) {
    const std::vector<FlowVector> equal(points, vector_at({0.1, 0.1}, {2, -1}));
    for (const VelocityEvidence& one : map.gather(equal, window, in_one)) {
      if (one.cell == 20 * 40 + 20) return one.xx;
    }
    return -1.0f;
  };
  constexpr double of_one{0.5 / (0.5 * 0.5)};  // half of a point's information, which enters several frames
  EXPECT_NEAR(information_of(1), of_one, 1e-5);
  EXPECT_NEAR(information_of(4), 4 * of_one, 1e-5);
  EXPECT_NEAR(information_of(20), 4 * of_one, 1e-5);
}

// A lattice with steps of 3 m/s has no velocity near one in the middle between two.
TEST(EvidenceMap, IsNoMorePreciseThanTheLattice) {
  EvidenceMap map{40, {-6, -3, 0, 3, 6}};
  const std::vector<FlowVector> precise(4, vector_at({0.1, 0.1}, {1.5, 1.5}, 0.1));
  for (const VelocityEvidence& one : map.gather(precise, window, in_one)) {
    if (one.cell != 20 * 40 + 20) continue;
    EXPECT_NEAR(one.xx, 1 / (0.1 * 0.1 / 2 + 3 * 3 / 6.0), 1e-5);
    EXPECT_GT(likelihood_of(one, 3.0f, 3.0f), 0.05f);
  }
}

TEST(EvidenceMap, IsTheSameHoweverTheRowsAreDivided) {
  const std::vector<FlowVector> points{vector_at({0.1, 0.1}, {2, -1}), vector_at({0.4, 0.3}, {3, 0}),
                                       vector_at({-2, 1.5}, {0, 1}), vector_at({0.2, -0.2}, {1, 1})};
  EvidenceMap map{40, continuous_axis()};
  const std::vector<VelocityEvidence> expected{map.gather(points, window, in_one)};
  ASSERT_FALSE(expected.empty());
  const auto from_the_end = [](int count, const auto& work) {
    for (int end{count}; end > 0; end -= 3) work(std::max(end - 3, 0), end);
  };
  const std::vector<VelocityEvidence>& divided{map.gather(points, window, from_the_end)};
  ASSERT_EQ(divided.size(), expected.size());
  for (std::size_t i{0}; i < expected.size(); ++i) {
    const auto numbers = [](const VelocityEvidence& one) {
      return std::tuple{one.cell, one.x, one.y, one.xx, one.xy, one.yy};
    };
    EXPECT_EQ(numbers(divided[i]), numbers(expected[i]));
  }
}

TEST(EvidenceMap, PointsThatContradictEachOtherSayLittle) {
  EvidenceMap map{40, continuous_axis()};
  const auto information_at_middle = [&](Point2 second) {
    for (const VelocityEvidence& one :
         map.gather({vector_at({0.1, 0.1}, {2, 0}), vector_at({0.1, 0.1}, second)}, window, in_one)) {
      if (one.cell == 20 * 40 + 20) return one.xx;
    }
    return -1.0f;
  };
  const float agreeing{information_at_middle({2, 0})};
  EXPECT_GT(agreeing, 0);
  EXPECT_LT(information_at_middle({-4, 0}), agreeing / 5);
}

// Three features at 3 m/s; one measured 9 m/s, with a large error, the other place is a wrong match.
TEST(EvidenceMap, FeaturesAreAveragedWithThoseThatAgree) {
  EvidenceMap map{40, continuous_axis()};
  std::vector<FlowVector> features(3, vector_at({0.1, 0.1}, {3, 0}));
  features.push_back(vector_at({-1.3, 0.1}, {6, 0}, 2));
  features.push_back(vector_at({-1.3, 0.1}, {-8, 0}));
  const auto at = [&](int cell) {
    for (const VelocityEvidence& one : map.gather(features, window, in_one)) {
      if (one.cell == cell) return one;
    }
    return VelocityEvidence{};
  };
  constexpr int near_both{20 * 40 + 13};
  EXPECT_EQ(at(20 * 40 + 20).starts_motion, 1);
  EXPECT_EQ(at(near_both).starts_motion, 0) << "one supported feature";
  features.pop_back();
  EXPECT_NEAR(at(near_both).x, 3, 0.1);
  features.back().place.x = 3.5;  // too far away
  EXPECT_EQ(at(20 * 40 + 20).starts_motion, 0) << "three in all";
  EXPECT_NEAR(at(20 * 40 + 37).x, 6, 1e-5);
}

TEST(EvidenceMap, MarksStandstillThatIsSeenAgainFromTheSamePlace) {
  EvidenceMap map{40, continuous_axis()};
  const auto mark = [&](Point2 velocity, double travelled_m) {
    const CameraView view{{-3, 0, 0}, 1, 1, 56 * travelled_m, 56};
    for (const VelocityEvidence& one : map.gather({vector_at({0.1, 0.1}, velocity)}, window, in_one, view)) {
      if (one.cell == 20 * 40 + 20) return one.is_repeated;
    }
    return -1;
  };
  EXPECT_EQ(mark({0, 0}, 0), 1);
  EXPECT_EQ(mark({3, 0}, 0), 0) << "it moves";
  EXPECT_EQ(mark({0, 0}, 0.5), 0) << "3 m away the disparity has changed by 3 px";
}

TEST(EvidenceMap, IsNotFasterThanTheLatticeAndStaysInTheWindow) {
  EvidenceMap map{40, continuous_axis()};
  for (const VelocityEvidence& one :
       map.gather({vector_at({3.9, 3.9}, {13, -20}), vector_at({50, 0}, {1, 1})}, window, in_one)) {
    EXPECT_EQ(one.x, 8);
    EXPECT_EQ(one.y, -8);
    EXPECT_LT(one.cell, 1600);
  }
}

}  // namespace
}  // namespace stereogrid::test
