// SPDX-License-Identifier: Apache-2.0
//
// Edges of lower ground and low obstacles in memory as obstacles, and lines through the sides of obstacles.
#include "obstacles/segmentation/side_fit.hpp"
#include "painted_obstacles.hpp"

namespace stereogrid::test {
namespace {

constexpr double sure_m{0.7};

/// Points of an edge straight ahead, one a sector, from left to right.
std::vector<EdgePoint> edge_at(double x, int first_sector, int count) {
  std::vector<EdgePoint> edges;
  for (int i{0}; i < count; ++i) edges.push_back({first_sector + i, {x, 2 - 0.1 * (first_sector + i)}, 0.8f});
  return edges;
}

std::vector<Cluster> drops_of(const std::vector<EdgePoint>& edges) {
  GroundSeenFree world;
  std::vector<Cluster> clusters;
  add_drops({edges, sure_m}, world.layers, {}, clusters);
  fit_boxes(clusters);
  return clusters;
}

TEST(Drops, AreLinesAlongTheEdge) {
  const std::vector<Cluster> drops{drops_of(edge_at(5, 0, 40))};
  ASSERT_EQ(drops.size(), 1u);
  EXPECT_EQ(drops[0].kind, ObstacleKind::drop);
  EXPECT_EQ(drops[0].outline.size(), 24u);
  EXPECT_NEAR(drops[0].outline[0].y, 2, 1e-9);
  EXPECT_NEAR(drops[0].outline[23].y, -1.9, 1e-9);
  EXPECT_NEAR(drops[0].length_m, 3.9, 1e-6);
  EXPECT_NEAR(drops[0].height_m, -0.8, 1e-6);
}

TEST(Drops, EndWhereTheEdgeDoes) {
  std::vector<EdgePoint> edges{edge_at(5, 0, 10)};
  const std::vector<EdgePoint> behind{edge_at(7, 10, 10)};
  const std::vector<EdgePoint> aside{edge_at(7, 26, 2)};
  edges.insert(edges.end(), behind.begin(), behind.end());
  edges.insert(edges.end(), aside.begin(), aside.end());
  const std::vector<Cluster> drops{drops_of(edges)};
  ASSERT_EQ(drops.size(), 2u) << "two points are none";
  EXPECT_EQ(drops[0].centre.x, 5);
  EXPECT_EQ(drops[1].centre.x, 7);
  EXPECT_TRUE(drops_of({}).empty());
}

TEST(Drops, JoinPointsOfAnEdgeAcrossTwoMissingSectorsAndFourCells) {
  const auto edge_with_gap = [](int missing, double step_x_m) {
    std::vector<EdgePoint> edges{edge_at(5, 0, 10)};
    for (const EdgePoint& point : edge_at(5 + step_x_m, 10 + missing, 10)) edges.push_back(point);
    return drops_of(edges).size();
  };
  EXPECT_EQ(edge_with_gap(2, 0), 1u);
  EXPECT_EQ(edge_with_gap(4, 0), 2u);
  EXPECT_EQ(edge_with_gap(0, 0.7), 1u) << "cells of 0.2 m";
  EXPECT_EQ(edge_with_gap(0, 1), 2u);
}

TEST(Drops, HaveTheOccupancyOfTheirCells) {
  EXPECT_NEAR(drops_of(edge_at(5, 0, 10)).at(0).occupancy, 0.1, 1e-6);
  EXPECT_NEAR(drops_of(edge_at(50, 0, 10)).at(0).occupancy, 0.5, 1e-6) << "outside the grid";
}

// Errors of matching are correlated over some sectors, and make short edges in frame after frame.
TEST(Drops, AreConfirmedByLongEdgesOnly) {
  const auto is_confirmed = [](int sectors, double metres_a_sector) {
    TrackedBlobs run;
    for (int step{0}; step < 10; ++step) {
      std::vector<EdgePoint> edges;
      for (int i{0}; i < sectors; ++i) edges.push_back({i, {5 - 0.1 * step, 1 - metres_a_sector * i}, 0.8f});
      run.update(drops_of(edges), 0.1);
    }
    return run.report().at(0).confirmed;
  };
  EXPECT_TRUE(is_confirmed(12, 0.1));
  EXPECT_FALSE(is_confirmed(11, 0.1)) << "fewer sectors than three errors";
  EXPECT_FALSE(is_confirmed(12, 0.05)) << "narrower than a passage";
}

TEST(Drops, AreTrackedApartFromObjectsAndStandStill) {
  TrackedBlobs run;
  std::vector<Obstacle> found;
  for (int step{0}; step < 6; ++step) {
    std::vector<Cluster> seen{drops_of(edge_at(5 - 0.1 * step, 0, 40))};
    seen.push_back(blob_at(5 - 0.1 * step, 0));
    run.update(seen, 0.1);
    found = run.report();
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].confirmed, step >= 2);
  }
  EXPECT_EQ(found[0].id, 1);
  EXPECT_EQ(found[0].kind, ObstacleKind::drop);
  EXPECT_FALSE(found[0].moving);
  EXPECT_NEAR(found[0].x_m, 4.5, 0.1);
  EXPECT_EQ(found[1].kind, ObstacleKind::object);
}

/// Cells between two ones of GroundSeenFree, which are 0.2 m wide. Cell (35, 25) has its middle at (5.1, 0.1).
std::vector<LowObstacleCell> low_cells(CellIndex first, CellIndex last, float frames = 0.5f, bool is_seen = true) {
  std::vector<LowObstacleCell> cells;
  for (int iy{first.iy}; iy <= last.iy; ++iy) {
    for (int ix{first.ix}; ix <= last.ix; ++ix) cells.push_back({ix, iy, 0.2f, frames, is_seen});
  }
  return cells;
}

std::vector<Cluster> low_objects_of(std::vector<LowObstacleCell> cells) {
  GroundSeenFree world;
  std::vector<Cluster> clusters;
  add_low_objects(cells, world.layers, {}, clusters);
  return clusters;
}

TEST(LowObjects, AreCellsThatTouch) {
  std::vector<LowObstacleCell> cells{low_cells({35, 25}, {36, 26})};
  cells.push_back({37, 27, 0.3f, 0.5f, false});
  cells.push_back({40, 27, 0.3f, 1, true});
  const std::vector<Cluster> found{low_objects_of(cells)};
  ASSERT_EQ(found.size(), 1u) << "a lone cell is none";
  EXPECT_EQ(found[0].kind, ObstacleKind::object);
  EXPECT_TRUE(found[0].is_low);
  EXPECT_TRUE(found[0].is_seen);
  EXPECT_NEAR(found[0].height_m, 0.3, 1e-6);
  EXPECT_NEAR(found[0].occupancy, 0.1, 1e-6);
  EXPECT_NEAR(found[0].centre.x, 5.3, 0.05);
  EXPECT_NEAR(found[0].centre.y, 0.3, 0.05);
  EXPECT_NEAR(found[0].bounds.least.x, 5, 1e-9);
  EXPECT_NEAR(found[0].bounds.most.y, 0.6, 1e-9);
  EXPECT_LE(found[0].outline.size(), 8u);
}

TEST(LowObjects, NeedTheWeightOfAFrame) {
  EXPECT_EQ(low_objects_of(low_cells({35, 25}, {36, 25}, 0.5f)).size(), 1u);
  EXPECT_EQ(low_objects_of(low_cells({35, 25}, {36, 25}, 0.4f)).size(), 0u);
  EXPECT_TRUE(low_objects_of({}).empty());
}

TEST(LowObjects, KerbsAreLinesAlongTheirNearSide) {
  const Cluster kerb{low_objects_of(low_cells({15, 30}, {58, 31})).at(0)};
  EXPECT_EQ(kerb.kind, ObstacleKind::boundary) << "8.8 m";
  EXPECT_GT(kerb.outline.size(), 6u);
  EXPECT_LE(kerb.outline.size(), 12u);
  for (const Point2& point : kerb.outline) EXPECT_NEAR(point.y, 1.2, 0.11) << "middles of cells";
  EXPECT_LT(kerb.outline[0].x, kerb.outline[kerb.outline.size() - 1].x) << "from left to right";
  std::vector<LowObstacleCell> corner{low_cells({20, 25}, {40, 25})};
  for (const LowObstacleCell& cell : low_cells({20, 26}, {20, 40})) corner.push_back(cell);
  EXPECT_EQ(low_objects_of(corner).at(0).kind, ObstacleKind::boundary) << "fills little of its box";
}

TEST(LowObjects, KeepTheirTrackWhileTheyAreInMemory) {
  TrackedBlobs run;
  const auto step = [&](bool is_seen, bool is_in_memory = true) {
    run.update(is_in_memory ? low_objects_of(low_cells({35, 25}, {36, 26}, 1, is_seen)) : std::vector<Cluster>{}, 0.1);
    return run.report();
  };
  EXPECT_TRUE(step(false).empty()) << "begins where it is seen";
  EXPECT_FALSE(step(true).at(0).confirmed);
  step(true);
  const Obstacle seen{step(true).at(0)};
  EXPECT_TRUE(seen.confirmed);
  EXPECT_FALSE(seen.coasting);
  for (int i{0}; i < 30; ++i) step(false);
  const Obstacle remembered{step(false).at(0)};
  EXPECT_EQ(remembered.id, seen.id);
  EXPECT_TRUE(remembered.confirmed);
  EXPECT_TRUE(remembered.coasting);
  EXPECT_NEAR(remembered.unseen_s, 3.1, 1e-6);
  EXPECT_EQ(remembered.x_m, seen.x_m);
  EXPECT_EQ(remembered.vx_mps, 0);
  EXPECT_TRUE(step(false, false).empty());
}

TEST(LowObjects, LeaveTheTracksOfOthersAlone) {
  TrackedBlobs run;
  for (int i{0}; i < 4; ++i) run.update({blob_at(5.2, 0.2)}, 0.1);
  ASSERT_EQ(run.report().at(0).id, 1);
  run.update(low_objects_of(low_cells({35, 25}, {36, 26}, 1)), 0.1);
  const std::vector<Obstacle> found{run.report()};
  ASSERT_EQ(found.size(), 2u);
  EXPECT_TRUE(found[0].coasting) << "it is not the low one";
  EXPECT_EQ(found[1].id, 2);
  EXPECT_TRUE(run.tracker.strips_of(2, {}).empty());
}

/// Strips of 10 columns from column 0 on, with these disparities and 0.3 px of noise.
std::vector<SideSample> samples_of(const std::vector<double>& disparities) {
  std::vector<SideSample> samples;
  for (std::size_t i{0}; i < disparities.size(); ++i) {
    samples.push_back({10.0 * static_cast<double>(i), 10.0 * static_cast<double>(i) + 10, disparities[i], 0.3});
  }
  return samples;
}

TEST(SideFit, PlanesHaveTwoPoints) {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> noise{-0.25, 0.25};
  std::vector<double> disparities;
  for (int i{0}; i < 12; ++i) disparities.push_back(20 + 0.05 * (10 * i + 5) + noise(random));
  const SideFit fit{samples_of(disparities), 12, 0};
  ASSERT_EQ(fit.size(), 2U);
  EXPECT_EQ(fit.column(0), 0);
  EXPECT_EQ(fit.column(1), 120);
  EXPECT_NEAR(fit.disparity(0), 20, 0.3);
  EXPECT_NEAR(fit.disparity(1), 26, 0.3);
}

TEST(SideFit, CornersHaveAPoint) {
  std::vector<double> disparities;
  for (int i{0}; i < 12; ++i) disparities.push_back(30 - 0.1 * std::abs(10 * i + 5 - 40));
  const SideFit fit{samples_of(disparities), 4, 0};
  ASSERT_EQ(fit.size(), 3U);
  EXPECT_EQ(fit.column(1), 40);
  EXPECT_NEAR(fit.disparity(0), 26, 0.05);
  EXPECT_NEAR(fit.disparity(1), 30, 0.05);
}

TEST(SideFit, PointsHaveALeastGain) {
  std::vector<double> disparities;
  for (int i{0}; i < 12; ++i) disparities.push_back(20 + (i % 2 == 0 ? 0.35 : -0.35));
  EXPECT_GT((SideFit{samples_of(disparities), 12, 0}.size()), 6U);
  const SideFit level{samples_of(disparities), 12, 20};
  ASSERT_EQ(level.size(), 2U);
  EXPECT_NEAR(level.disparity(0), 20, 0.1);
}

TEST(SideFit, PointsAreLimited) {
  std::vector<double> teeth;
  for (int i{0}; i < 12; ++i) teeth.push_back(i % 2 == 0 ? 20 : 30);
  for (const std::size_t most : {2U, 4U, 12U}) {
    SideFit fit{samples_of(teeth), most, 0};
    EXPECT_LE(fit.size(), most);
    for (std::size_t i{0}; i < fit.size(); ++i) {
      EXPECT_GE(fit.disparity(i), 19);
      EXPECT_LE(fit.disparity(i), 31);
      EXPECT_TRUE(i == 0 || fit.column(i) > fit.column(i - 1)) << i;
    }
    const std::size_t points{fit.size()};
    fit.refit(samples_of(std::vector<double>(12, 15)));
    EXPECT_EQ(fit.size(), points);
    for (std::size_t i{0}; i < fit.size(); ++i) EXPECT_NEAR(fit.disparity(i), 15, 1e-9);
  }
}

TEST(SideFit, OneSampleIsLevel) {
  const SideFit fit{samples_of({25}), 4, 0};
  ASSERT_EQ(fit.size(), 2U);
  EXPECT_NEAR(fit.disparity(0), 25, 1e-9);
  EXPECT_NEAR(fit.disparity(1), 25, 1e-9);
}

}  // namespace
}  // namespace stereogrid::test
