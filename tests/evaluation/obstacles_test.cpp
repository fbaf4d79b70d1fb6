// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/obstacles.hpp"

#include "support.hpp"

namespace stereogrid::evaluation::testing {
namespace {

std::vector<Point2> rectangle(double x, double y, double length, double width) {
  const double l{length / 2};
  const double w{width / 2};
  return {{x + l, y + w}, {x - l, y + w}, {x - l, y - w}, {x + l, y - w}};
}

/// A box on the axes, seen at ten places along its near side.
Thing thing(std::int64_t id, double x, double y, double length = 4, double width = 2) {
  Thing made{id, "car", {}, 0.3, rectangle(x, y, length, width), length * width, {x, y}, length, width, std::nullopt};
  for (int i{0}; i < 10; ++i) made.seen.push_back({x - length / 2, y - width / 2 + (i + 0.5) * width / 10});
  return made;
}

Obstacle box(std::int64_t id, double x, double y, double length = 4, double width = 2) {
  Obstacle made;
  made.id = id;
  made.x_m = x;
  made.y_m = y;
  made.length_m = length;
  made.width_m = width;
  made.confirmed = true;
  return made;
}

ObstacleSummary scored(const ObstacleTruth& truth, const std::vector<Obstacle>& reported, int frames = 1) {
  ObstacleScores scores;
  for (int i{0}; i < frames; ++i) scores.add(truth, reported);
  return scores.summary();
}

ObstacleTruth with(std::vector<Thing> things) {
  ObstacleTruth truth;
  truth.has_cell_truth = true;
  truth.things = std::move(things);
  return truth;
}

TEST(Obstacles, OfTheTruthItself) {
  const ObstacleSummary s(scored(with({thing(1, 10, 0), thing(2, 10, 5)}), {box(7, 10, 0), box(8, 10, 5)}, 3));
  EXPECT_EQ(s.frames, 3U);
  EXPECT_EQ(s.things, 6U);
  EXPECT_EQ(s.separate, 1);
  EXPECT_EQ(s.found, 1);
  EXPECT_EQ(s.in_extended + s.merged + s.split, 0);
  EXPECT_EQ(s.by_kind.at("car").separate, 6U);
  EXPECT_EQ(s.area_median_m2, 8);
  EXPECT_EQ(s.tracking.mota, 1);
  EXPECT_EQ(s.tracking.idf1, 1);
  EXPECT_EQ(s.centre_error_m + s.nearest_edge_error_m + s.length_error_m + s.width_error_m, 0);
  EXPECT_TRUE(std::isnan(s.free_covered));
  EXPECT_TRUE(std::isnan(s.moving_wrong));
}

TEST(Obstacles, ShapesOfOutlines) {
  Obstacle straight{box(7, 10, 0)};
  straight.outline = {{8, -1}, {8, 1}, {8, 1}, {12, 1}, {12, -1}};
  Obstacle teeth{box(8, 10, 5)};
  teeth.kind = ObstacleKind::boundary;
  teeth.outline = {{8, 4}, {9, 4}, {9, 5}, {8, 5}};
  const ObstacleSummary s(scored(with({}), {straight, teeth}));
  EXPECT_EQ(s.corners, 4) << "the repeated point does not count";
  EXPECT_NEAR(s.turns_per_m, 6.0 / 15, 1e-12);
  EXPECT_TRUE(std::isnan(s.near_side_sigmas));
}

TEST(Obstacles, DistancesOfNearSides) {
  ObstacleTruth truth(with({thing(1, 10, 0)}));
  EXPECT_TRUE(std::isnan(scored(truth, {box(7, 10, 0)}).near_side_sigmas)) << "labelled boxes";
  truth.sigma_per_m2 = 0.01;  // 0.64 m at the near side, 8 m ahead
  EXPECT_NEAR(scored(truth, {box(7, 10, 0)}).near_side_sigmas, 0, 1e-12);
  EXPECT_NEAR(scored(truth, {box(7, 10.16, 0)}).near_side_sigmas, 0.25, 1e-12);
  EXPECT_NEAR(scored(truth, {box(7, 9.84, 0)}).near_side_sigmas, 0.25, 1e-12) << "nearer";
}

TEST(Obstacles, ThatAreNotConfirmedDoNotCount) {
  auto unsure{box(7, 10, 0)};
  unsure.confirmed = false;
  const ObstacleSummary s(scored(with({thing(1, 10, 0)}), {unsure}));
  EXPECT_EQ(s.separate, 0);
  EXPECT_EQ(s.found, 0);
  EXPECT_TRUE(std::isnan(s.area_median_m2));
}

TEST(Obstacles, HalfOfWhatIsSeenIsEnough) {
  // the near side reaches from y = -1 to 1, one place every 0.2 m; 0.3 m around the box count
  const auto reaching_to = [](double y) {
    auto one{box(7, 10, 0)};
    one.outline = {{8, y}, {12, y}, {12, y + 1.5}, {8, y + 1.5}};
    return one;
  };
  EXPECT_EQ(scored(with({thing(1, 10, 0)}), {reaching_to(0.25)}).separate, 1);  // from -0.05 on: 5 of 10
  EXPECT_EQ(scored(with({thing(1, 10, 0)}), {reaching_to(0.45)}).separate, 0);  // 4 of 10
}

TEST(Obstacles, ThatHoldMoreThanTheThingAreNotItsOwn) {
  // 8 m², so that an own obstacle has 18 m² or less
  EXPECT_EQ(scored(with({thing(1, 10, 0)}), {box(7, 10, 0, 4, 4.5)}).separate, 1);
  const ObstacleSummary s(scored(with({thing(1, 10, 0)}), {box(7, 10, 0, 4, 4.6)}));
  EXPECT_EQ(s.separate, 0);
  EXPECT_EQ(s.found, 1);
  EXPECT_EQ(s.tracking.misses, 1U);
}

TEST(Obstacles, MergeThings) {
  const ObstacleSummary s(
      scored(with({thing(1, 10, 0), thing(2, 10, 2.5), thing(3, 10, -8)}), {box(7, 10, 1.25, 4, 4.5), box(8, 10, -8)}));
  EXPECT_DOUBLE_EQ(s.merged, 2.0 / 3);
  EXPECT_EQ(s.separate, 1);           // 18 m² is twice 8 m² and 2 m²: the script calls that their own
  EXPECT_EQ(s.tracking.matches, 2U);  // but it stands for one of them only
  EXPECT_EQ(s.tracking.misses, 1U);
}

TEST(Obstacles, SplitAThing) {
  const ObstacleSummary s(scored(with({thing(1, 10, 0)}), {box(7, 10, 0.5, 4, 1), box(8, 10, -0.5, 4, 1)}));
  EXPECT_EQ(s.split, 1);
  EXPECT_EQ(s.merged, 0);
  EXPECT_EQ(s.tracking.matches, 1U);
  EXPECT_EQ(s.tracking.false_positives, 1U);  // the other half
  // beside the thing, though within reach of its seen points
  EXPECT_EQ(scored(with({thing(1, 10, 0)}), {box(7, 10, 0), box(8, 10, 2.2)}).split, 0);
}

TEST(Obstacles, MayBeOpenLines) {
  auto wall{box(7, 8, 0, 0.2, 8)};
  wall.kind = ObstacleKind::boundary;
  wall.outline = {{8, -4}, {8, 4}, {16, 4}};  // closed, it would contain the cells in between
  ObstacleTruth truth{with({thing(1, 10, 0), thing(2, 13, 2, 1, 1)})};
  truth.free = {{12, 3}};
  const ObstacleSummary s(scored(truth, {wall}));
  EXPECT_EQ(s.separate, 0);
  EXPECT_EQ(s.found, 0.5);
  EXPECT_EQ(s.in_extended, 0.5);
  EXPECT_EQ(s.free_covered, 0);
  EXPECT_TRUE(std::isnan(s.area_median_m2));
  EXPECT_EQ(s.tracking.false_positives, 0U);
  EXPECT_EQ(scored(truth, {wall, box(8, 10, 0)}).in_extended, 0);
}

TEST(Obstacles, CoverFreeCells) {
  ObstacleTruth truth{with({})};
  truth.free = {{9, 0}, {10, 0}, {11, 0}, {15, 0}};
  truth.occupied = {{10, 0.5}, {11, 0.5}, {15, 0.5}};
  // 7 holds three free cells and two others, 8 one of each, 9 none at all
  const ObstacleSummary s(scored(truth, {box(7, 10, 0), box(8, 15, 0, 1, 2), box(9, 5, 5)}));
  EXPECT_EQ(s.free_cells, 4U);
  EXPECT_EQ(s.free_covered, 1);
  EXPECT_EQ(s.tracking.false_positives, 2U);
  EXPECT_TRUE(s.has_complete_truth);
  EXPECT_DOUBLE_EQ(s.area_p90_m2, 8);
  EXPECT_EQ(s.area_median_m2, 8);
}

TEST(Obstacles, SeemToMove) {
  ObstacleTruth truth{with({})};
  truth.movers = {{{10, 0}, 2}};
  const auto moving = [](double x, double vx, bool said) {
    auto one{box(7, x, 0)};
    one.vx_mps = vx;
    one.moving = said;
    return one;
  };
  const ObstacleSummary s(
      scored(truth, {moving(13.4, 2, false), moving(13.6, 2, false), moving(15, 0.5, true), moving(17, 0.9, false)}));
  EXPECT_EQ(s.moving, 3U);
  EXPECT_DOUBLE_EQ(s.moving_wrong, 2.0 / 3);
}

// Whether the grid's motion is that of the obstacles.
TEST(Obstacles, CellsMoveByStandingObstacles) {
  ObstacleScores scores;
  auto mover{box(7, 10, 0)};
  mover.moving = true;
  const std::vector<Point2> cells{{10, 0}, {8, 6.3}, {8, 6.5}, {12.2, 0}, {12, 3}};
  scores.add(with({}), std::vector{mover, box(8, 8, 5), box(9, 14, 0, 3, 2)}, cells);
  scores.add(with({}), {}, {});
  EXPECT_EQ(scores.summary().moving_cells, 5U);
  EXPECT_DOUBLE_EQ(scores.summary().moving_cells_standing, 1.0 / 5) << "one is near to both, two to none";
  EXPECT_TRUE(std::isnan(scored(with({}), {}).moving_cells_standing));
}

TEST(Obstacles, ErrorsOfWhatIsMatched) {
  Thing mover{thing(1, 10, 0)};
  mover.velocity_mps = Point2{0, 4};
  auto found{box(7, 10.5, 0, 3, 1.5)};  // from 9 to 12; the thing: from 8 to 12
  found.vx_mps = 3;
  found.vy_mps = 4;
  found.yaw_rad = 0;
  found.moving = true;
  for (const Point2 corner : rectangle(10.2, 0, 3.6, 2)) found.outline.push_back(corner);  // from 8.4 on
  mover.seen = {{9, 0}};
  const ObstacleSummary s(scored(with({mover}), {found}));
  EXPECT_EQ(s.speed_error_mps, 3);
  EXPECT_EQ(s.centre_error_m, 0.5);
  EXPECT_EQ(s.tracking.motp, 0.5);
  EXPECT_NEAR(s.nearest_edge_error_m, 0.4, 1e-12);
  EXPECT_EQ(s.length_error_m, 1);
  EXPECT_EQ(s.width_error_m, 0.5);
  EXPECT_EQ(s.movers, 1U);
  EXPECT_EQ(s.mover_speed_error_mps, 1);
  EXPECT_EQ(s.headings, 1U);
  EXPECT_NEAR(s.heading_error_deg, 90, 1e-9);
}

TEST(Obstacles, AreFollowed) {
  ObstacleScores scores;
  const ObstacleTruth truth{with({thing(1, 10, 0)})};
  for (const std::int64_t id : {7, 7, 8}) scores.add(truth, std::vector{box(id, 10, 0)});
  scores.add(truth, {});
  scores.add(truth, std::vector{box(8, 10, 0)});
  const TrackingSummary s(scores.summary().tracking);
  EXPECT_EQ(s.id_switches, 1U);
  EXPECT_EQ(s.fragmentations, 1U);
  EXPECT_DOUBLE_EQ(s.mota, 1 - 2.0 / 5);
  EXPECT_DOUBLE_EQ(s.idf1, 2.0 * 2 / (5 + 4));
}

TEST(Obstacles, TruthOfLabelledBoxes) {
  const Rig rig{small_rig()};
  LabelledObject car{3, "car", 10, 0, 4, 2, 0, 0, Point2{5, 0}, true};
  LabelledObject hidden{car};
  hidden.occluded = 2;
  hidden.moving.reset();
  LabelledObject far{car};
  far.x_m = 30;
  far.moving = false;
  const ObstacleTruth truth{obstacle_truth(std::vector{car, hidden, far}, rig, nullptr)};
  ASSERT_EQ(truth.things.size(), 1U);
  EXPECT_EQ(truth.things[0].seen.size(), 22U);  // points of two sides
  for (const Point2 p : truth.things[0].seen) EXPECT_TRUE(p.x == 8 || std::abs(p.y) == 1) << p.x << " " << p.y;
  EXPECT_EQ(truth.things[0].velocity_mps.value().x, 5);
  EXPECT_EQ(truth.movers.size(), 2U);
  EXPECT_EQ(truth.movers[0].radius_m, 2);
  EXPECT_FALSE(truth.has_cell_truth);
  EXPECT_FALSE(scored(truth, {}).has_complete_truth);
  const Labels labels{lane_labels("0010f1")};
  const ObstacleTruth of_cells{obstacle_truth({}, rig, &labels)};
  EXPECT_EQ(of_cells.free.size(), 2U);  // from 3 m on
  EXPECT_EQ(of_cells.occupied.size(), 1U);
}

TEST(Obstacles, ExactTruth) {
  Rig rig;
  rig.focal_px = 300;
  rig.baseline_m = 0.5;
  FrameTruth truth;
  const TruthGrid grid{{0, -5, 1, 25, 10}, 0.15, 1.8};
  truth.ego.world_from_vehicle = {100, 50, std::numbers::pi / 2};  // ahead is the world's y
  truth.state = {25, 10, static_cast<std::uint8_t>(TruthCell::seen_free)};
  truth.low = {25, 10};
  truth.low(4, 4) = 1;
  truth.seen_object = {25, 10};
  const auto put = [&truth](int ix, int iy, int id) {
    truth.state(ix, iy) = static_cast<std::uint8_t>(TruthCell::seen_occupied);
    truth.seen_object(ix, iy) = id;
  };
  put(8, 5, 3);
  put(8, 6, 3);
  put(12, 5, 4);
  put(22, 5, 3);  // too far
  TruthObject car{3, "car", {100, 60, std::numbers::pi / 2}, 0, 2, 1.5, {2, 4, 1.5}, {}, 250};
  car.footprint = {{101, 58}, {101, 62}, {99, 62}, {99, 58}};
  TruthObject wall{car};
  wall.id = 4;
  wall.kind = "wall";
  truth.objects = {car, wall};
  const ObstacleTruth known{obstacle_truth(truth, grid, rig)};
  EXPECT_EQ(known.free.size(), 17U * 10 - 3 - 1);
  EXPECT_EQ(known.occupied.size(), 3U);
  EXPECT_NEAR(known.sigma_per_m2, 0.3 / 150, 1e-12);
  EXPECT_EQ(known.movers.size(), 2U);
  EXPECT_NEAR(known.movers[0].centre.x, 10, 1e-9);
  ASSERT_EQ(known.things.size(), 1U);
  const Thing& thing{known.things[0]};
  EXPECT_EQ(thing.seen.size(), 2U);
  EXPECT_EQ(thing.seen[0].x, 8.5);
  EXPECT_NEAR(thing.centre.x, 10, 1e-9);
  EXPECT_NEAR(thing.centre.y, 0, 1e-9);
  EXPECT_NEAR(thing.length_m, 4, 1e-9);
  EXPECT_NEAR(thing.width_m, 2, 1e-9);
  EXPECT_NEAR(thing.velocity_mps.value().x, 2, 1e-9);
  EXPECT_NEAR(thing.velocity_mps.value().y, 0, 1e-9);
}

TEST(Obstacles, OfTheFirstSecondAreLeftOut) {
  EXPECT_FALSE(is_settled(9, 13));
  EXPECT_TRUE(is_settled(10, 13));
  EXPECT_TRUE(is_settled(0, 12));
}

}  // namespace
}  // namespace stereogrid::evaluation::testing
