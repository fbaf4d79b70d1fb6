// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/frame.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace stereogrid::test {
namespace {

void expect_same(const Pose2& a, const Pose2& b) {
  EXPECT_NEAR(a.x_m, b.x_m, 1e-12);
  EXPECT_NEAR(a.y_m, b.y_m, 1e-12);
  EXPECT_NEAR(std::remainder(a.yaw_rad - b.yaw_rad, 2 * pi), 0, 1e-12);
}

TEST(Pose, TurnsCounterClockwiseThenMoves) {
  const Pose2 world_from_vehicle{10, 20, 90 * degree};
  // 3 m ahead of a car that faces +y, and 1 m to its left, which is −x
  const Point2 in_world{world_from_vehicle * Point2{3, 1}};
  EXPECT_NEAR(in_world.x, 9, 1e-12);
  EXPECT_NEAR(in_world.y, 23, 1e-12);
}

TEST(Pose, CompositionIsOneAfterTheOther) {
  const Pose2 a_from_b{1, 2, 0.3};
  const Pose2 b_from_c{-4, 0.5, 1.1};
  const Point2 in_c{0.7, -2.2};
  const Point2 at_once{(a_from_b * b_from_c) * in_c};
  const Point2 in_steps{a_from_b * (b_from_c * in_c)};
  EXPECT_NEAR(at_once.x, in_steps.x, 1e-12);
  EXPECT_NEAR(at_once.y, in_steps.y, 1e-12);
  expect_same(Pose2{1, 2, 90 * degree} * Pose2{1, 0, 0}, {1, 3, 90 * degree});
}

TEST(Pose, CompositionKeepsTheHeadingInRange) {
  const Pose2 turned{Pose2{0, 0, 3} * Pose2{0, 0, 3}};
  EXPECT_NEAR(turned.yaw_rad, 6 - 2 * pi, 1e-12);
  const Pose2 back{Pose2{0, 0, -3} * Pose2{0, 0, -3}};
  EXPECT_NEAR(back.yaw_rad, 2 * pi - 6, 1e-12);
}

TEST(Pose, InverseUndoes) {
  std::mt19937 generator{5};
  for (int i{0}; i < 50; ++i) {
    const Pose2 a_from_b{uniform(generator, -50, 50), uniform(generator, -50, 50), uniform(generator, -3, 3)};
    expect_same(a_from_b * inverse(a_from_b), {});
    expect_same(inverse(a_from_b) * a_from_b, {});
  }
  expect_same(inverse(Pose2{1, 2, 90 * degree}), {-2, 1, -90 * degree});
}

}  // namespace
}  // namespace stereogrid::test
