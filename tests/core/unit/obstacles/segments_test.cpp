// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/segments.hpp"

#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

const Ground level{1.2, 0, 0, true};

std::size_t segments_of(const PaintedObstacles& painted) {
  Segmenter segmenter{PaintedObstacles::rig(), PaintedObstacles::disparities};
  segmenter.find(nodes_in(painted.disparity.view(), level), level);
  return segmenter.size();
}

std::vector<Cluster> clusters_of(const PaintedObstacles& painted, const GridLayers& world = still_world(),
                                 const Pose2& world_from_vehicle = {}) {
  ClusterWorkspace space{obstacle_space()};
  find_clusters(painted.disparity.view(), level, world, world_from_vehicle, {}, space);
  fit_boxes(space.clusters);
  return space.clusters;
}

// Even–odd rule.
bool holds(const Outline& outline, Point2 at) {
  bool inside{false};
  for (std::size_t i{0}; i < outline.size(); ++i) {
    const Point2 a{outline[i]};
    const Point2 b{outline[(i + 1) % outline.size()]};
    if ((a.y > at.y) != (b.y > at.y) && at.x < (b.x - a.x) * (at.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
  }
  return inside;
}

TEST(Segments, AGapInTheImageSeparates) {
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(8, 0.5, 2.5)), 1u);
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(8, 0.5, 2.5).wall(8, -2, 0)), 2u);
}

TEST(Segments, AStepInDepthSeparates) {
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(10, 0, 4).wall(8, -2, 0)), 2u);
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(8.2, 0, 2).wall(8, -2, 0)), 1u) << "not so small a one";
}

// As the side of a car falls apart that is seen at a grazing angle.
TEST(Segments, PiecesOfAThingAreJoined) {
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(7.9, 1.3, 1.6).wall(7, 1, 1.35)), 1u);
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(9, 1.5, 1.8).wall(7.9, 1.3, 1.6).wall(7, 1, 1.35)), 1u);
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(7.9, 1.3, 1.6, 0, 2.4).wall(7, 1, 1.35)), 2u) << "of other heights";
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(7.9, 0.05, 2.9).wall(7, -3, 0)), 2u) << "longer than a car";
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(7.9, 1.9, 2.2).wall(7, 1, 1.35)), 2u) << "with a gap in the image";
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(9.5, 1.6, 1.9).wall(7, 1, 1.35)), 2u) << "far behind";
}

TEST(Segments, WhatStandsBeforeSomethingIsAThingOfItsOwn) {
  const PaintedObstacles painted{PaintedObstacles{}.wall(12, -2.5, 2.5).wall(6, -0.3, 0.3)};
  ClusterWorkspace space{obstacle_space()};
  space.segmenter.find(nodes_in(painted.disparity.view(), level), level);
  EXPECT_EQ(space.segmenter.segment_at({6, 0}), space.segmenter.segment_at({6, 0.2}));
  EXPECT_NE(space.segmenter.segment_at({6, 0}), space.segmenter.segment_at({12, 2}));
  EXPECT_GE(space.segmenter.segment_at({12, 2}), 0);
  EXPECT_EQ(space.segmenter.segment_at({9, 2}), -1);
  EXPECT_EQ(space.segmenter.segment_at({-6, 0}), -1);
}

// Matching windows across an edge of depth give everything in between.
TEST(Segments, DisparitiesBetweenTwoSurfacesDoNotJoinThem) {
  PaintedObstacles painted{PaintedObstacles{}.wall(12, -2.5, 2.5).wall(6, -0.3, 0.3)};
  const int edge{PaintedObstacles::column(6, -0.3)};
  for (const auto [i, v] : raster(0, 4, 60, 120)) painted.disparity(edge + i, v) = 12.0f - 1.3f * static_cast<float>(i);
  ClusterWorkspace space{obstacle_space()};
  space.segmenter.find(nodes_in(painted.disparity.view(), level), level);
  EXPECT_NE(space.segmenter.segment_at({6, 0}), space.segmenter.segment_at({12, -2}));
}

TEST(Segments, WhatIsSmallOrLowIsIgnored) {
  PaintedObstacles painted;
  painted.wall(10, 0, 3, 0, 0.2);
  EXPECT_EQ(segments_of(painted), 0u) << "a kerb";
  painted.wall(10, 0, 0.1, 0, 0.5);
  EXPECT_EQ(segments_of(painted), 0u) << "two columns";
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(10, 0, 3, 2, 4)), 0u) << "above the vehicle";
}

TEST(Segments, ALongRowIsCutWhereItIsThin) {
  PaintedObstacles row;
  row.side(5, 9, 2);
  row.side(9.6, 13, 2);
  for (const auto [v, u] : raster(160, 256)) {
    // a part as low as a bumper joins them
    const double x_m{400.0 / (128 - (u + 0.5))};
    if (x_m > 9 && x_m < 9.6 && v > 80 + 200 * 0.8 / x_m && v < 80 + 200 * 1.2 / x_m) {
      row.disparity(u, v) = static_cast<float>(80 / x_m);
    }
  }
  EXPECT_GE(segments_of(row), 2u);
  EXPECT_EQ(segments_of(PaintedObstacles{}.side(5, 10, 2)), 1u) << "as long as a van";
}

TEST(Segments, OutlineOfAThingLiesBehindWhatIsSeenOfIt) {
  const std::vector<Cluster> found{clusters_of(PaintedObstacles{}.wall(8, -1, 1))};
  ASSERT_EQ(found.size(), 1u);
  const Cluster& car{found[0]};
  EXPECT_EQ(car.kind, ObstacleKind::object);
  EXPECT_TRUE(holds(car.outline, {8.2, 0}));
  EXPECT_TRUE(holds(car.outline, {8.2, 0.9}));
  EXPECT_FALSE(holds(car.outline, {7.5, 0}));
  EXPECT_FALSE(holds(car.outline, {9.2, 0}));
  EXPECT_FALSE(holds(car.outline, {8.2, 1.3}));
  EXPECT_NEAR(car.length_m, 2, 0.2);
  EXPECT_NEAR(car.width_m, 0.5, 0.2);
  EXPECT_NEAR(std::abs(car.yaw_rad), 90 * degree, 6 * degree);
  EXPECT_NEAR(car.height_m, 1.5, 0.1);
  EXPECT_NEAR(car.centre.x, 8.25, 0.2);
  EXPECT_NEAR(car.centre.y, 0, 0.1);
  EXPECT_NEAR(car.occupancy, 0.9, 1e-6);
  for (const Point2& point : car.outline) {
    EXPECT_GE(point.x, car.bounds.least.x);
    EXPECT_LE(point.y, car.bounds.most.y);
  }
}

// Cut by the image's edge (on the left the right camera's, which sees less), or by a nearer obstacle.
TEST(Segments, SayWhereTheyMayGoOn) {
  const auto cuts = [](const PaintedObstacles& painted, double x_m) {
    for (const Cluster& one : clusters_of(painted)) {
      if (std::abs(one.bounds.least.x - x_m) < 0.5) return std::pair{one.is_cut_left, one.is_cut_right};
    }
    ADD_FAILURE() << "nothing at " << x_m;
    return std::pair{false, false};
  };
  EXPECT_EQ(cuts(PaintedObstacles{}.wall(8, -1, 1), 8), std::pair(false, false));
  EXPECT_EQ(cuts(PaintedObstacles{}.wall(8, 2, 4.9), 8), std::pair(true, false));
  EXPECT_EQ(cuts(PaintedObstacles{}.wall(8, -6, -3), 8), std::pair(false, true));
  EXPECT_EQ(cuts(PaintedObstacles{}.wall(12, 0, 3).wall(6, -1, 0.5), 12), std::pair(false, true));
  EXPECT_EQ(cuts(PaintedObstacles{}.wall(12, 0, 3).wall(6, -1, 0.5), 6), std::pair(false, false));
}

TEST(Segments, OutlinesAreInTheWorld) {
  const Pose2 at{20, -3, 90 * degree};
  GridLayers world{still_world()};
  world.geometry.x_min_m = 0;
  const std::vector<Cluster> found{clusters_of(PaintedObstacles{}.wall(8, -1, 1), world, at)};
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].centre.x, 20, 0.2);
  EXPECT_NEAR(found[0].centre.y, 5.25, 0.2);
}

double cross(Point2 a, Point2 b, Point2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// True if two edges intersect. The corner of consecutive edges does not count.
bool meet(Point2 a, Point2 b, Point2 c, Point2 d) {
  const auto between = [](double p, double q) { return p * q < -1e-9; };
  return between(cross(a, b, c), cross(a, b, d)) && between(cross(c, d, a), cross(c, d, b));
}

// On the ray where two strips meet, the near side comes before the far side.
bool is_simple(const Outline& outline) {
  const std::size_t n{outline.size()};
  const auto at = [&](std::size_t i) { return outline[i % n]; };
  for (std::size_t i{0}; i < n; ++i) {
    for (std::size_t j{i + 2}; j < n; ++j) {
      if (meet(at(i), at(i + 1), at(j), at(j + 1))) return false;
    }
  }
  for (std::size_t strip{0}; strip + 1 < n / 4; ++strip) {
    const double near_m{std::max(at(2 * strip + 1).x, at(2 * strip + 2).x)};
    const double far_m{std::min(at(n - 2 * strip - 2).x, at(n - 2 * strip - 3).x)};
    if (!(near_m < far_m)) return false;
  }
  return true;
}

/// Fitted: each point of the far side lies behind that of the near side with the same column.
bool is_fitted_simple(const Outline& outline) {
  const std::size_t n{outline.size()};
  for (std::size_t i{0}; i < n / 2; ++i) {
    const Point2 near{outline[i]};
    const Point2 far{outline[n - 1 - i]};
    if (!(far.x > near.x + 0.49) || std::abs(near.y / near.x - far.y / far.x) > 1e-9) return false;
    if (i > 0 && !(near.y / near.x < outline[i - 1].y / outline[i - 1].x)) return false;
  }
  return n >= 4 && n <= 8 && n % 2 == 0;
}

TEST(Segments, OutlinesOfCratesAreBoxes) {
  const std::vector<Cluster> found{clusters_of(PaintedObstacles{}.wall(8, -1, 1))};
  ASSERT_EQ(found.size(), 1U);
  ASSERT_EQ(found[0].fitted.size(), 4U);
  EXPECT_NEAR(found[0].fitted[0].x, found[0].fitted[1].x, 1e-6);
}

// Slanted and ragged surfaces: depths jump from strip to strip.
TEST(Segments, OutlinesOfThingsAreSimplePolygons) {
  std::mt19937 random{5};
  std::uniform_real_distribution<double> any{0, 1};
  int things{0};
  for (int round{0}; round < 60; ++round) {
    PaintedObstacles painted;
    double x_m{6 + 4 * any(random)};
    for (int u{60}; u < 190; ++u) {
      if (u % 4 == 0) x_m = std::clamp(x_m + 1.2 * (any(random) - 0.5), 4.0, 16.0);
      painted.strip(u, x_m, 0, 1.5);
    }
    for (const Cluster& cluster : clusters_of(painted)) {
      if (cluster.kind != ObstacleKind::object) continue;
      ++things;
      EXPECT_EQ(cluster.outline.size() % 4, 0U);
      EXPECT_TRUE(is_simple(cluster.outline)) << round;
      EXPECT_TRUE(is_fitted_simple(cluster.fitted)) << round;
    }
  }
  EXPECT_GT(things, 60);
}

// The parts are worked on at the same time: no two write to one place.
TEST(Segments, PartsMakeNoDifference) {
  const PaintedObstacles painted{PaintedObstacles{}.wall(12, -2.5, 2.5).wall(6, -0.3, 0.3).side(5, 10, 2)};
  const std::vector<ColumnNode> whole{nodes_in(painted.disparity.view(), level)};
  const std::vector<ColumnNode> parts{nodes_in(painted.disparity.view(), level, [](int count, const auto& work) {
    for (int i{6}; i >= 0; --i) work(count * i / 7, count * (i + 1) / 7);
  })};
  EXPECT_GT(whole.size(), 100U);
  EXPECT_EQ(parts, whole);
}

// A device counts the nodes in any order.
TEST(Segments, OrderOfNodesMakesNoDifference) {
  const PaintedObstacles painted{PaintedObstacles{}.wall(12, -2.5, 2.5).wall(6, -0.3, 0.3).side(5, 10, 2)};
  std::vector<ColumnNode> nodes{nodes_in(painted.disparity.view(), level)};
  Segmenter ordered{PaintedObstacles::rig(), PaintedObstacles::disparities};
  ordered.find(nodes, level);
  std::shuffle(nodes.begin(), nodes.end(), std::mt19937{3});
  Segmenter shuffled{PaintedObstacles::rig(), PaintedObstacles::disparities};
  shuffled.find(nodes, level);
  ASSERT_EQ(shuffled.size(), ordered.size());
  for (std::size_t i{0}; i < ordered.size(); ++i) {
    ASSERT_TRUE(std::ranges::equal(shuffled.of(i), ordered.of(i)));
    for (const int node : ordered.of(i)) {
      EXPECT_EQ(shuffled.node(node).pixels, ordered.node(node).pixels);
      EXPECT_EQ(shuffled.node(node).top_m, ordered.node(node).top_m);
    }
  }
}

TEST(Segments, AWallIsALineAndNoBox) {
  const std::vector<Cluster> found{clusters_of(PaintedObstacles{}.wall(14, -6, 6))};
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, ObstacleKind::boundary);
  for (const Point2& point : found[0].outline) EXPECT_NEAR(point.x, 14, 0.5);
  EXPECT_GT(found[0].outline[0].y, 5);
  EXPECT_LT(found[0].outline[found[0].outline.size() - 1].y, -5);
}

TEST(Segments, LongThingsHigherThanAVanAreBoundaries) {
  EXPECT_EQ(clusters_of(PaintedObstacles{}.wall(12, -2.5, 2.5, 0, 3)).at(0).kind, ObstacleKind::object);
  EXPECT_EQ(clusters_of(PaintedObstacles{}.wall(12, -2.5, 2.5, 0, 4.2)).at(0).kind, ObstacleKind::boundary);
  EXPECT_EQ(clusters_of(PaintedObstacles{}.wall(12, -1, 1, 0, 4.2)).at(0).kind, ObstacleKind::object) << "a tree";
}

// 0.23 m over the lowest height, at 20 m.
TEST(Segments, ThatShowTwoRowsAreFound) {
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(20, -1, 1, 0, 0.48)), 1u);
}

TEST(Segments, AreFoundUpToFortyMetres) {
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(38, -3, 3)), 1u);
  EXPECT_EQ(segments_of(PaintedObstacles{}.wall(44, -3, 3)), 0u);
}

TEST(Segments, HeightEndsWhereSomethingHangsAboveAGap) {
  PaintedObstacles painted;
  painted.wall(8, -1, 1, 0, 1.5).wall(8, -1, 1, 2.3, 3);
  EXPECT_NEAR(clusters_of(painted).at(0).height_m, 1.5, 0.1);
  painted.wall(8, -1, 1, 1.5, 1.9);  // the rest is lower than half a metre
  EXPECT_NEAR(clusters_of(painted).at(0).height_m, 3, 0.1);
}

TEST(Segments, OneColumnInTenMayBeHigher) {
  PaintedObstacles painted;
  painted.wall(8, -1, 1, 0, 1.5).wall(8, 0.9, 1, 1.5, 4);
  EXPECT_NEAR(clusters_of(painted).at(0).height_m, 1.5, 0.1);
}

TEST(Segments, VelocityIsThatOfItsCellsIfTheyMove) {
  GridLayers world{still_world()};
  world.velocity_x.fill(2);
  world.velocity_y.fill(1);
  world.moving.fill(0.3f);
  EXPECT_EQ(clusters_of(PaintedObstacles{}.wall(8, -0.5, 0.5), world).at(0).velocity.x, 0);
  world.moving.fill(0.8f);
  const Cluster moving{clusters_of(PaintedObstacles{}.wall(8, -0.5, 0.5), world).at(0)};
  EXPECT_NEAR(moving.velocity.x, 2, 1e-6);
  EXPECT_NEAR(moving.velocity.y, 1, 1e-6);
  EXPECT_NEAR(moving.yaw_rad, std::atan2(1, 2), 1e-6) << "the box lies along the motion";
}

TEST(Segments, EmptyImagesHaveNone) {
  EXPECT_EQ(segments_of(PaintedObstacles{}), 0u);
  PaintedObstacles everything;
  everything.disparity.fill(20);
  EXPECT_LE(segments_of(everything), 1u);
}

}  // namespace
}  // namespace stereogrid::test
