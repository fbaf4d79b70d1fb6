// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "truth/truth.hpp"
#include "world/height_field.hpp"
#include "world/numbers.hpp"
#include "world/shapes.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {
namespace {

TEST(Angle, AgreesWithTheStandardLibrary) {
  for (double angle{-20}; angle < 20; angle += 0.0137) {
    const Direction direction{direction_of(angle)};
    EXPECT_NEAR(direction.cosine, std::cos(angle), 2e-15) << angle;
    EXPECT_NEAR(direction.sine, std::sin(angle), 2e-15) << angle;
  }
  EXPECT_EQ(direction_of(0).cosine, 1);
  EXPECT_EQ(direction_of(0).sine, 0);
}

TEST(Random, GaussianHasUnitDeviation) {
  double sum{0};
  double squares{0};
  constexpr int count{200000};
  for (int i{0}; i < count; ++i) {
    const double x{gaussian(scramble(static_cast<std::uint64_t>(i)))};
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / count, 0, 0.01);
  EXPECT_NEAR(squares / count, 1, 0.01);
}

/// Below 0 inside, above 0 outside.
double outside(const Solid& solid, Vector3 p) {
  const Vector3 q{std::abs(p.x / solid.half.x), std::abs(p.y / solid.half.y), std::abs(p.z / solid.half.z)};
  switch (solid.shape) {
    case Shape::box:
      return std::max({q.x, q.y, q.z}) - 1;
    case Shape::cylinder:
      return std::max(std::hypot(q.x, q.y), q.z) - 1;
    case Shape::wheel:
      return std::max(std::hypot(q.x, q.z), q.y) - 1;
    default:
      return std::sqrt(dot(q, q)) - 1;
  }
}

class SolidTest : public testing::TestWithParam<Shape> {};

TEST_P(SolidTest, RaysEnterWhereTheSolidBegins) {
  const Solid solid{GetParam(), {0.7, 0.4, 1.1}};
  Random random{7};
  int hits{0};
  for (int i{0}; i < 3000; ++i) {
    const Vector3 origin{random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
    const Vector3 target{random.between(-1.2, 1.2), random.between(-1.2, 1.2), random.between(-1.2, 1.2)};
    if (outside(solid, origin) <= 0) continue;
    const Vector3 direction{target - origin};
    Entry entry;
    const bool hit{enters(solid, origin, direction, 1e9, entry)};
    const double until{hit ? entry.t - 1e-6 : 3.0};
    for (double t{0}; t < until; t += 0.01) ASSERT_GT(outside(solid, origin + t * direction), 0) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(outside(solid, origin + entry.t * direction), 0, 1e-9);
    EXPECT_NEAR(dot(entry.normal, entry.normal), 1, 1e-12);
    EXPECT_LE(dot(entry.normal, direction), 0);
    EXPECT_FALSE(enters(solid, origin, direction, 0.999 * entry.t, entry));
  }
  EXPECT_GT(hits, 500);
}

TEST_P(SolidTest, OutlineHoldsEverythingBetweenTheHeights) {
  const Solid solid{GetParam(), {0.7, 0.4, 1.1}};
  const Polygon polygon{convex_hull(outline(solid, 0.5, 0.9))};
  ASSERT_GE(polygon.size(), 4U);
  Random random{11};
  for (int i{0}; i < 5000; ++i) {
    const Vector3 p{random.between(-0.8, 0.8), random.between(-0.5, 0.5), random.between(0.5, 0.9)};
    if (outside(solid, p) > 0) continue;
    for (std::size_t k{0}; k < polygon.size(); ++k) {
      const Point2 a{polygon[k]};
      const Point2 b{polygon[(k + 1) % polygon.size()]};
      EXPECT_GE((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x), -1e-9);
    }
  }
  EXPECT_TRUE(outline(solid, 1.2, 2).empty());
  EXPECT_TRUE(outline(solid, -3, -1.1).empty());
}

INSTANTIATE_TEST_SUITE_P(Shapes, SolidTest,
                         testing::Values(Shape::box, Shape::cylinder, Shape::wheel, Shape::ellipsoid));

TEST(Polygon, HullDropsInnerAndCollinearPoints) {
  const Polygon hull{convex_hull({{0, 0}, {1, 1}, {2, 0}, {1, 0}, {2, 2}, {0, 2}, {0.5, 1.5}, {2, 2}})};
  ASSERT_EQ(hull.size(), 4U);
  EXPECT_NEAR(area_within(hull, {-9, -9}, {9, 9}), 4, 1e-12);  // positive: counter-clockwise
}

TEST(Polygon, AreaWithinARectangle) {
  const Polygon triangle{{0, 0}, {2, 0}, {0, 2}};
  EXPECT_NEAR(area_within(triangle, {0, 0}, {1, 1}), 1, 1e-12);
  EXPECT_NEAR(area_within(triangle, {1, 0}, {2, 1}), 0.5, 1e-12);
  EXPECT_EQ(area_within(triangle, {3, 3}, {4, 4}), 0);
  EXPECT_EQ(area_within(triangle, {-1, 0}, {0, 1}), 0);  // only touches
  EXPECT_EQ(area_within({}, {0, 0}, {1, 1}), 0);
}

TEST(Motion, FollowsAnArcBetweenItsInstants) {
  const Motion motion{{1, 2, 0.3}, 2, 0.1, 1, 4};
  EXPECT_EQ(motion.pose_at(0), motion.pose_at(1));
  EXPECT_EQ(motion.pose_at(4), motion.pose_at(9));
  EXPECT_EQ(motion.speed_at(0.9), 0);
  EXPECT_EQ(motion.speed_at(1), 2);
  EXPECT_EQ(motion.speed_at(4), 0);
  const Pose2 pose{motion.pose_at(3)};  // 4 m along: 0.4 rad
  EXPECT_NEAR(pose.yaw_rad, 0.7, 1e-12);
  EXPECT_NEAR(pose.x_m, 1 + 10 * (std::sin(0.7) - std::sin(0.3)), 1e-12);
  EXPECT_NEAR(pose.y_m, 2 - 10 * (std::cos(0.7) - std::cos(0.3)), 1e-12);
}

TEST(Motion, LeftOfAnArcIsLeft) {
  const Pose2 pose{along_arc({0, 0, 0}, 0.1, 0, 3)};
  EXPECT_NEAR(pose.x_m, 0, 1e-12);
  EXPECT_NEAR(pose.y_m, 3, 1e-12);
  EXPECT_NEAR(along_arc({0, 0, pi / 2}, 0, 5, 3).x_m, -3, 1e-12);
}

/// A ramp, a ditch beside the path, a bank that begins gradually, and waves.
HeightField mixed_ground() {
  Relief relief;
  relief.add({{{4, 0}, {8, 0.8}}});
  relief.add({{{5, 0}, {5, -0.6}, {6, -0.6}, {6, 0}}}, between(-1, 2));
  relief.add({{{9, 0}, {12, 1}}}, {{{-10, -1.5}, {10, 1.5}}});
  relief.add(Polyline{{{13, 0}}}.wave(0.4, 3).wave(-0.4, 3));
  return relief.field();
}

/// The first of many close places along a ray that lies below the ground; −1: none.
double marched(const HeightField& ground, Vector3 origin, Vector3 direction) {
  for (double t{0}; t < 30; t += 5e-4) {
    const Vector3 at{origin + t * direction};
    if (at.z < ground.height_at(at.x, at.y)) return t;
  }
  return -1;
}

TEST(Relief, AddsProducts) {
  const HeightField ground{mixed_ground()};
  EXPECT_EQ(ground.height_at(0, 0), 0);
  EXPECT_NEAR(ground.height_at(4.5, 0), 0.1, 1e-12);
  EXPECT_NEAR(ground.height_at(5.5, 1.9), 0.3 - 0.6, 1e-12);
  EXPECT_NEAR(ground.height_at(5.5, 2.1), 0.3, 1e-12);
  EXPECT_NEAR(ground.height_at(10.5, 4), 0.8 + 0.5 * 0.6, 1e-12);
  EXPECT_NEAR(ground.height_at(12.5, -20), 0.8 - 1.5, 1e-12);
  EXPECT_NEAR(ground.height_at(16, 0), 1.2, 1e-12);
}

TEST(HeightField, RaysEndWhereTheGroundBegins) {
  const HeightField ground{mixed_ground()};
  Random random{3};
  int walls{0};
  int misses{0};
  for (int i{0}; i < 400; ++i) {
    const Vector3 origin{random.between(-1, 3), random.between(-2, 2), random.between(1, 1.6)};
    const Vector3 direction{1, random.between(-0.5, 0.5), random.between(-0.4, 0.1)};
    const double expected{marched(ground, origin, direction)};
    HeightField::Crossing crossing;
    const bool found{ground.crosses(origin, direction, crossing) && crossing.t < 30};
    ASSERT_EQ(found, expected >= 0) << i;
    misses += found ? 0 : 1;
    if (!found) continue;
    EXPECT_NEAR(crossing.t, expected, 1e-3) << i;
    EXPECT_LT(dot(crossing.normal, direction), 0);
    walls += crossing.is_wall ? 1 : 0;
    if (crossing.is_wall) continue;
    const Vector3 at{origin + crossing.t * direction};
    EXPECT_NEAR(at.z, ground.height_at(at.x, at.y), 1e-9) << i;
  }
  EXPECT_GT(walls, 3);
  EXPECT_GT(misses, 3);
}

TEST(HeightField, WallsFaceTheRay) {
  Relief relief;
  relief.add({{{5, 0}, {5, 0.5}}});
  const HeightField ground{relief.field()};
  HeightField::Crossing crossing;
  ASSERT_TRUE(ground.crosses({0, 0, 1}, {1, 0, -0.15}, crossing));
  EXPECT_NEAR(crossing.t, 5, 1e-12);
  EXPECT_TRUE(crossing.is_wall);
  EXPECT_EQ(crossing.normal.x, -1);
  ASSERT_TRUE(ground.crosses({0, 0, 1}, {1, 0, -0.05}, crossing));
  EXPECT_NEAR(crossing.t, 10, 1e-12);
  EXPECT_FALSE(crossing.is_wall);
  EXPECT_FALSE(ground.crosses({6, 0, 0.4}, {1, 0, -0.05}, crossing)) << "starts below the ground";
  EXPECT_FALSE(ground.crosses({0, 0, 1}, {1, 0, 0.01}, crossing));
}

TEST(Chassis, StandsOnTheGround) {
  const Wheels wheels{1, 1, 0.5};
  Relief relief;
  relief.add({{{-50, -5}, {50, 5}}});
  const Frame3 climbing{standing_at(relief.field(), {2, 1, 0}, wheels)};
  const double tilt{std::atan(0.1)};
  EXPECT_NEAR(climbing.origin.z, 0.2, 1e-12);
  EXPECT_NEAR(climbing.forward.z, std::sin(tilt), 1e-12);
  EXPECT_NEAR(climbing.up.z, std::cos(tilt), 1e-12);
  EXPECT_NEAR(climbing.left.z, 0, 1e-12);
  const Frame3 beside{standing_at(relief.field(), {2, 1, 1.5707963267948966}, wheels)};
  EXPECT_NEAR(beside.left.z, -std::sin(tilt), 1e-12) << "the slope rises to the right";
  EXPECT_NEAR(beside.forward.z, 0, 1e-12);
  const Vector3 p{beside.back({3, -2, 0.5})};
  EXPECT_NEAR(beside.into(p).x, 3, 1e-12);
  EXPECT_NEAR(beside.into(p).y, -2, 1e-12);
  EXPECT_NEAR(beside.into(p).z, 0.5, 1e-12);
}

}  // namespace
}  // namespace stereogrid::scenes
