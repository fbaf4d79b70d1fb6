// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "motion/scene_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>
#include <vector>

#include "clusters_of.hpp"
#include "motion/velocity_evidence.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr double dt_s{0.1};

// A textured wall across the view, at a place of its own in every frame; the vehicle drives along x.
class Street {
 public:
  Street(Point2 wall, Point2 wall_velocity, double vehicle_mps = 0)
      : wall_{wall}, wall_velocity_{wall_velocity}, vehicle_mps_{vehicle_mps} {}

  // One more frame through scene flow.
  void step(SceneFlow& flow) {
    const double t_s{dt_s * frame_};
    const Point2 wall{wall_.x + (wall_velocity_.x - vehicle_mps_) * t_s, wall_.y + wall_velocity_.y * t_s};
    const double disparity{rig.focal_px * rig.baseline_m / wall.x};
    const Image<std::uint8_t> left{view_of(wall, 0)};
    const Image<std::uint8_t> right{view_of(wall, disparity, right_rows_off)};
    const FlowFrame frame{left.view(), right.view(), {}, {vehicle_mps_ * t_s, 0, 0}, frame_ == 0 ? 0 : dt_s};
    Matches matches{rig.width_px, rig.height_px};
    for (int v{first_matched_row}; v < std::min(end_of_matched_rows, rig.height_px); ++v) {
      std::fill_n(matches.obstacle.row(v), rig.width_px, static_cast<float>(disparity + 0.2));  // as matching errs
    }
    const auto here = [](int count, const auto& work) { work(0, count); };
    flow.follow(frame, here);
    flow.add_points(frame, matches, here);
    ++frame_;
  }

  Rig rig{small_kitti_rig()};
  int right_rows_off{0};
  int first_matched_row{0};
  int end_of_matched_rows{rig.height_px};
  /// Grey level by the place on the wall, in 40ths of a metre.
  std::function<double(double, double)> shade{[texture = Texture{7}](double x, double y) { return texture.at(x, y); }};

 private:
  // Metres of the wall are 40 px of its texture, so that it grows as it comes near.
  [[nodiscard]] Image<std::uint8_t> view_of(Point2 wall, double disparity, int rows_off = 0) const {
    Image<std::uint8_t> image{rig.width_px, rig.height_px};
    const double scale{40 * wall.x / rig.focal_px};
    for (int v{0}; v < rig.height_px; ++v) {
      for (int u{0}; u < rig.width_px; ++u) {
        const double across{scale * (u + disparity - rig.cx_px) + 40 * wall.y};
        image(u, v) = static_cast<std::uint8_t>(shade(across, scale * (v - rows_off - rig.cy_px)) + 0.5);
      }
    }
    return image;
  }

  Point2 wall_;
  Point2 wall_velocity_;
  double vehicle_mps_;
  int frame_{0};
};

double median(const std::vector<FlowVector>& vectors, double Point2::*axis) {
  std::vector<double> values;
  for (const FlowVector& vector : vectors) values.push_back(vector.velocity.*axis);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

TEST(SceneFlow, MeasuresVelocities) {
  for (const Point2 velocity : {Point2{0, 0}, Point2{0, 3}, Point2{0, -6}, Point2{-5, 0}, Point2{4, 1.5}}) {
    SCOPED_TRACE(testing::Message() << velocity.x << ", " << velocity.y << " m/s");
    Street street{{9, 0}, velocity};
    SceneFlow flow{street.rig};
    for (int i{0}; i < 6; ++i) street.step(flow);
    ASSERT_GT(flow.vectors().size(), 40u);
    EXPECT_NEAR(median(flow.vectors(), &Point2::x), velocity.x, 0.3);
    EXPECT_NEAR(median(flow.vectors(), &Point2::y), velocity.y, 0.15);
  }
}

TEST(SceneFlow, WhatStandsStandsForADrivingCamera) {
  Street street{{12, 0}, {0, 0}, 8};
  SceneFlow flow{street.rig};
  for (int i{0}; i < 6; ++i) street.step(flow);
  ASSERT_GT(flow.vectors().size(), 40u);
  EXPECT_NEAR(median(flow.vectors(), &Point2::x), 0, 0.3);
  EXPECT_NEAR(median(flow.vectors(), &Point2::y), 0, 0.15);
}

TEST(SceneFlow, IsLessSureAlongTheRayAndAtFirst) {
  Street street{{12, 0}, {0, 0}};
  SceneFlow flow{street.rig};
  street.step(flow);
  EXPECT_TRUE(flow.vectors().empty()) << "a point that has been seen once says nothing";
  street.step(flow);
  ASSERT_FALSE(flow.vectors().empty());
  const auto spread = [&] {
    const FlowVector& vector{*std::min_element(
        flow.vectors().begin(), flow.vectors().end(),
        [](const FlowVector& a, const FlowVector& b) { return std::abs(a.place.y) < std::abs(b.place.y); })};
    EXPECT_GT(vector.place_covariance.xx, 10 * vector.place_covariance.yy);
    EXPECT_NEAR(vector.place.x, 12, 0.5);
    return vector.velocity_covariance.xx;
  };
  const double at_first{spread()};
  for (int i{0}; i < 5; ++i) street.step(flow);
  EXPECT_LT(spread(), at_first / 4);
}

TEST(SceneFlow, LosesWhatIsNoLongerThereAndForgetsWhenTold) {
  Street street{{9, 0}, {0, 0}};
  SceneFlow flow{street.rig};
  for (int i{0}; i < 3; ++i) street.step(flow);
  ASSERT_FALSE(flow.vectors().empty());
  const Image<std::uint8_t> grey{street.rig.width_px, street.rig.height_px, std::uint8_t{90}};
  const auto here = [](int count, const auto& work) { work(0, count); };
  flow.follow({grey.view(), grey.view(), {}, {}, dt_s}, here);
  EXPECT_TRUE(flow.vectors().empty());

  for (int i{0}; i < 3; ++i) street.step(flow);
  ASSERT_FALSE(flow.vectors().empty());
  flow.clear();
  EXPECT_TRUE(flow.vectors().empty());
}

std::size_t vectors_of(Street street, int frames = 2) {
  SceneFlow flow{street.rig};
  for (int i{0}; i < frames; ++i) street.step(flow);
  return flow.vectors().size();
}

// Aperture problem: a horizontal edge may slide along itself.
TEST(SceneFlow, HorizontalEdgesAreNotFollowed) {
  for (const auto& [contrast, is_followed] : {std::pair{10.0, false}, {15.0, true}}) {
    Street street{{9, 0}, {0, 0}};
    street.shade = [contrast = contrast](double x, double y) {
      return 100 + 60 * std::sin(y / 3) + contrast * std::sin(x / 2.5) * std::cos(y / 9);
    };
    const std::size_t vectors{vectors_of(street)};
    EXPECT_TRUE(is_followed ? vectors > 20 : vectors == 0) << contrast << ": " << vectors;
  }
}

TEST(SceneFlow, ARightImageOfOtherRowsHasNoPoints) {
  for (const int rows : {0, 2, -2}) {
    Street street{{9, 0}, {0, 0}};
    street.right_rows_off = rows;
    const std::size_t vectors{vectors_of(street)};
    EXPECT_TRUE(rows == 0 ? vectors > 40 : vectors < 4) << rows << ": " << vectors;
  }
}

// A crown hangs above moving objects.
TEST(SceneFlow, WhatIsHigherThanThreeMetresIsNotFollowed) {
  Street street{{20, 0}, {0, 0}};
  const auto row_at = [&](double height_m) {
    return static_cast<int>(street.rig.cy_px - (height_m - street.rig.camera_height_m) * street.rig.focal_px / 20);
  };
  street.end_of_matched_rows = row_at(3.2);
  ASSERT_GT(street.end_of_matched_rows, 24);
  EXPECT_EQ(vectors_of(street), 0u);
  street.first_matched_row = row_at(2.8);
  street.end_of_matched_rows = street.rig.height_px;
  EXPECT_GT(vectors_of(street), 40u);
}

// Pickets of 12 px that have moved by nearly 2.5 of them, 29.5 px: several fit alike, and none of them is taken.
TEST(SceneFlow, APicketFenceIsNotSearchedAtRandom) {
  for (const bool has_pickets : {true, false}) {
    Street street{{9, 0}, {0, 29.5 / dt_s * 9 / small_kitti_rig().focal_px}};
    if (has_pickets) {
      const double period{12 * 40 * 9 / street.rig.focal_px};
      street.shade = [period](double x, double y) {
        return 100 + 60 * std::sin(2 * std::numbers::pi * x / period) + 20 * std::sin(y / 3);
      };
    }
    const std::size_t vectors{vectors_of(street, 2)};
    EXPECT_TRUE(has_pickets ? vectors < 10 : vectors > 40) << has_pickets << ": " << vectors;
  }
}

FlowVector vector_at(Point2 place, Point2 velocity, double sigma_mps = 0.5) {
  const double variance{sigma_mps * sigma_mps};
  return {place, {0.01, 0, 0.01}, velocity, {variance, 0, variance}};
}

constexpr GridGeometry window{-4, -4, 0.2, 40, 40};

TEST(EvidenceMap, CoversTheCellsAroundAPoint) {
  EvidenceMap map{40, 8};
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
  EvidenceMap map{40, 8};
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

TEST(EvidenceMap, IsTheSameHoweverTheRowsAreDivided) {
  const std::vector<FlowVector> points{vector_at({0.1, 0.1}, {2, -1}), vector_at({0.4, 0.3}, {3, 0}),
                                       vector_at({-2, 1.5}, {0, 1}), vector_at({0.2, -0.2}, {1, 1})};
  EvidenceMap map{40, 8};
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
  EvidenceMap map{40, 8};
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

TEST(EvidenceMap, MarksStandstillThatIsSeenAgainFromTheSamePlace) {
  EvidenceMap map{40, 8};
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
  EvidenceMap map{40, 8};
  for (const VelocityEvidence& one :
       map.gather({vector_at({3.9, 3.9}, {13, -20}), vector_at({50, 0}, {1, 1})}, window, in_one)) {
    EXPECT_EQ(one.x, 8);
    EXPECT_EQ(one.y, -8);
    EXPECT_LT(one.cell, 1600);
  }
}

// Two things side by side, 8 m ahead: from y = 1 to 2 m and from −2 to −1 m.
struct TwoClusters {
  TwoClusters() : space{obstacle_space()}, clusters{space.clusters} {
    const PaintedObstacles painted{PaintedObstacles{}.wall(8, 1, 2).wall(8, -2, -1)};
    find_clusters(painted.disparity.view(), {1.2, 0, 0, true}, still_world(), {}, {}, in_one, space);
    clusters.at(0).velocity = clusters.at(1).velocity = {0.5, 0};
    if (space.segmenter.segment_at({8, 1.5}) != 0) std::swap(first, second);
  }

  ClusterSpace space;
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
    ClusterSpace space{obstacle_space()};
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
    ClusterSpace space{obstacle_space()};
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
  world.geometry = window;
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
