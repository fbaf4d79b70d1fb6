// SPDX-License-Identifier: Apache-2.0
#include "motion/ego_error.hpp"

#include <gtest/gtest.h>

#include "painted_obstacles.hpp"

namespace stereogrid::test {
namespace {

constexpr double dt_s{0.1};
constexpr double speed_mps{10};
constexpr double focal_baseline{80};  // PaintedObstacles

using Vectors = std::vector<FlowVector>;

// Drives along x for two seconds. `vectors(x)`: of the frame with the vehicle at x.
template <class VectorsAt>
struct Drive {
  explicit Drive(const VectorsAt& vectors, double speed = speed_mps) {
    for (int frame{0}; frame <= 20; ++frame) {
      last = vectors(frame * dt_s * speed);
      error.correct({frame * dt_s * speed, 0}, dt_s, last);
    }
  }
  EgoError error{PaintedObstacles::rig(), 100};
  Vectors last;
};

// Static objects in eight sectors, 6 to 20 m ahead of the vehicle at x. `velocity(m)` ahead.
template <class Velocity>
Vectors static_scene(double x, const Velocity& velocity) {
  Vectors vectors;
  for (int object{0}; object < 8; ++object) {
    const double ahead_m{6.0 + 2 * object};
    const double y{ahead_m * (0.12 * object - 0.4)};
    for (int i{0}; i < 4; ++i) vectors.push_back(vector_at({x + ahead_m, y}, {velocity(ahead_m), 0}));
  }
  return vectors;
}

void add_object(Point2 at, Point2 velocity, Vectors& vectors) {
  for (int i{0}; i < 6; ++i) vectors.push_back(vector_at(at, velocity));
}

TEST(EgoError, ScaleOfTheMotionIsMeasuredAndRemoved) {
  const Drive drive{[](double x) { return static_scene(x, [](double) { return 0.07 * speed_mps; }); }};
  for (const FlowVector& vector : drive.last) EXPECT_NEAR(vector.velocity.x, 0, 0.15);
  EXPECT_LT(drive.last.front().common_covariance.xx, 0.3 * 0.3);
  EXPECT_EQ(drive.last.front().common_covariance.yy, 0) << "only along the motion";
}

// Disparities that are too small by 0.5 px, and the true motion.
TEST(EgoError, OffsetOfTheDisparitiesIsMeasuredAndRemoved) {
  const auto seeming = [](double ahead_m) { return -2 * 0.5 * ahead_m / focal_baseline * speed_mps; };
  const Drive drive{[&](double x) { return static_scene(x, seeming); }};
  EXPECT_GT(drive.error.offset_px(), 0.3);
  for (const FlowVector& vector : drive.last) EXPECT_NEAR(vector.velocity.x, 0, 0.2);
}

TEST(EgoError, MovingObjectsAmongStaticOnesKeepTheirVelocity) {
  const Drive drive{[](double x) {
    Vectors vectors{static_scene(x, [](double) { return 0.0; })};
    add_object({x + 8, 4.5}, {1.4, 0}, vectors);     // a pedestrian in the vehicle's direction
    add_object({x + 15, -7.5}, {-1.4, 0}, vectors);  // and another one
    add_object({x + 12, 1}, {speed_mps, 0}, vectors);
    return vectors;
  }};
  const FlowVector& pedestrian{drive.last[32]};
  EXPECT_NEAR(pedestrian.velocity.x, 1.4, 0.2);
  EXPECT_NEAR(drive.last.back().velocity.x, speed_mps, 0.2);
  EXPECT_GT(pedestrian.velocity.x * pedestrian.velocity.x, 9 * pedestrian.common_covariance.xx) << "still significant";
}

// One object says nothing about the ego-motion, however many features it has.
TEST(EgoError, AnObjectAloneIsNoMeasurement) {
  const Drive drive{[](double x) {
    Vectors vectors;
    add_object({x + 8, 1}, {1.4, 0}, vectors);
    return vectors;
  }};
  EXPECT_EQ(drive.error.scale(), 0);
  EXPECT_EQ(drive.last.front().velocity.x, 1.4);
  const double scale_mps{0.05 * speed_mps};
  const double offset_mps{2 * 0.5 * 8 / focal_baseline * speed_mps};
  EXPECT_NEAR(drive.last.front().common_covariance.xx, scale_mps * scale_mps + offset_mps * offset_mps, 1e-9);
}

TEST(EgoError, AStandingVehicleHasNone) {
  const Drive drive{[](double x) { return static_scene(x, [](double) { return 1.0; }); }, 0};
  EXPECT_EQ(drive.last.front().velocity.x, 1);
  EXPECT_EQ(drive.last.front().common_covariance.xx, 0);
}

}  // namespace
}  // namespace stereogrid::test
