// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "world/height_field.hpp"
#include "world/numbers.hpp"
#include "world/relief.hpp"

namespace stereogrid::scenes {
namespace {

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
