// SPDX-License-Identifier: Apache-2.0
//
// Whether tracks move, how they turn, and where their sides are.
#include "painted_obstacles.hpp"

namespace stereogrid::test {
namespace {

TEST(Symmetric2, PrincipalDirectionIsThatOfTheLargestSpread) {
  for (int degrees{-89}; degrees <= 90; ++degrees) {
    const double c{std::cos(degrees * pi / 180)};
    const double s{std::sin(degrees * pi / 180)};
    const Point2 found{principal_direction({9 * c * c + s * s, 8 * c * s, 9 * s * s + c * c})};
    EXPECT_NEAR(found.x, c, 1e-7) << degrees;
    EXPECT_NEAR(found.y, s, 1e-7) << degrees;
  }
  const Point2 any{principal_direction({2, 0, 2})};
  EXPECT_EQ(any.x, 1);
  EXPECT_EQ(any.y, 0);
}

// Positions alone are no evidence of motion: the visible part of an object changes, and its centre with it.
TEST(Tracker, PlacesAloneAreNoMotion) {
  TrackedBlobs run;
  for (int step{0}; step < 25; ++step) run.update({blob_at(0.14 * step, 2 - 0.06 * step)}, 0.1);
  const Obstacle last{run.report()[0]};
  EXPECT_EQ(last.vx_mps, 0);
  EXPECT_FALSE(last.moving);
  EXPECT_NEAR(last.x_m, 0.14 * 24, 0.4) << "it is followed nevertheless";
}

TEST(Tracker, MotionTakesSeveralFramesOfEvidence) {
  TrackedBlobs run;
  Cluster blob{blob_at(3, 0, {5, 0})};
  blob.velocity_covariance = {0.16, 0, 0.16};
  for (int step{0}; step < 2; ++step) {
    run.update({blob}, 0);
    EXPECT_FALSE(run.report()[0].moving) << step;
  }
  for (int step{0}; step < 4; ++step) run.update({blob}, 0);
  EXPECT_TRUE(run.report()[0].moving);
  blob.kind = ObstacleKind::boundary;
  for (int step{0}; step < 4; ++step) run.update({blob}, 0);
  EXPECT_FALSE(run.report()[0].moving) << "walls do not move";
  EXPECT_EQ(run.report()[0].kind, ObstacleKind::boundary);
}

// Sides that are surely seen err by 0.2 m all the same, alike from frame to frame.
TEST(Tracker, APlaceErrsByTwentyCentimetresAFrame) {
  TrackedBlobs run;
  constexpr int frames{40};
  for (int step{0}; step < frames; ++step) run.update({blob_at(3, 0)}, 0);
  const double of_a_frame_m{std::sqrt(frames * run.report().at(0).position_covariance.xx)};
  EXPECT_GT(of_a_frame_m, 0.2);
  EXPECT_LT(of_a_frame_m, 0.3);
}

// With a tree above it, velocities of points say nothing.
TEST(Tracker, ATallThingEarnsNoMotion) {
  for (const auto& [height_m, moves] : {std::pair{4.0, true}, {4.4, false}, {6.0, false}}) {
    TrackedBlobs run;
    Cluster blob{blob_at(3, 0, {5, 0})};
    blob.velocity_covariance = {0.16, 0, 0.16};
    blob.height_m = height_m;
    for (int step{0}; step < 6; ++step) run.update({blob}, 0);
    EXPECT_EQ(run.report()[0].moving, moves) << height_m;
  }
}

// Half of the squared velocity in variances, less 2, is evidence: 3 are against motion, 5 for it.
TEST(Tracker, EvidenceOfMotionBeginsAtTwoStandardDeviations) {
  for (const auto& [square, moves] : {std::pair{3.0, false}, {3.9, false}, {4.6, true}}) {
    TrackedBlobs run;
    Cluster blob{blob_at(3, 0, {3, 0})};
    blob.velocity_covariance = {9 / square, 0, 9 / square};
    for (int step{0}; step < 40; ++step) run.update({blob}, 0);
    EXPECT_EQ(run.report()[0].moving, moves) << square;
  }
}

// The filter has followed its cells before there was a thing.
TEST(Tracker, WhatTheFilterHasSeenMovingNeedsLessEvidence) {
  for (const double share : {0.0, 1.0}) {
    TrackedBlobs run;
    for (int step{0}; step < 3; ++step) {
      Cluster blob{blob_at(3 + 0.2 * step, 0, {2, 0})};
      blob.velocity_covariance = {0.1, 0, 0.1};
      blob.moving = share;
      run.update({blob}, 0.1);
      EXPECT_EQ(run.report().front().moving, step >= (share > 0.5 ? 1 : 2)) << step;
    }
  }
}

// At the image's border parts of static objects enter or leave the view.
TEST(Tracker, SlowMotionOfWhatIsCutOffNeedsMoreEvidence) {
  for (const bool is_cut : {false, true}) {
    for (const double speed_mps : {1.5, 4.0}) {
      TrackedBlobs run;
      for (int step{0}; step < 5; ++step) {
        Cluster blob{blob_at(3 + 0.1 * speed_mps * step, 0, {speed_mps, 0})};
        blob.velocity_covariance = {0.1, 0, 0.1};
        blob.is_cut_right = is_cut;
        run.update({blob}, 0.1);
        EXPECT_EQ(run.report().front().moving, step >= (is_cut && speed_mps < 2 ? 4 : 2)) << step;
      }
    }
  }
}

TEST(Tracker, ReportsInTheVehicleFrame) {
  TrackedBlobs run;
  Cluster blob{blob_at(4, 3, {2, 1})};
  blob.yaw_rad = 30 * degree;
  blob.velocity_covariance = {0.09, 0, 0.09};
  for (int step{0}; step < 4; ++step) run.update({blob}, 0);
  // the car stands at (4, 1) and faces +y: the blob is 2 m ahead, moves to the right and away
  const Obstacle seen{run.report({4, 1, 90 * degree}).at(0)};
  EXPECT_NEAR(seen.x_m, 2, 0.01);
  EXPECT_NEAR(seen.y_m, 0, 0.01);
  EXPECT_NEAR(seen.vx_mps, 1, 1e-6);
  EXPECT_NEAR(seen.vy_mps, -2, 1e-6);
  EXPECT_NEAR(seen.yaw_rad, std::atan2(-2, 1), 1e-6) << "its box lies along its motion";
  // around an outline of 0.6 × 0.4 m
  const double c{std::cos(std::atan2(1, 2))};
  const double s{std::sin(std::atan2(1, 2))};
  EXPECT_NEAR(seen.length_m, 0.6 * c + 0.4 * s, 0.03);
  EXPECT_NEAR(seen.width_m, 0.6 * s + 0.4 * c, 0.03);
  EXPECT_NEAR(seen.occupancy, 0.9, 1e-9);
  const Obstacle in_world{run.report().at(0)};
  ASSERT_EQ(seen.outline.size(), 4u);
  EXPECT_NEAR(seen.outline[0].x, 2.2, 1e-6);
  EXPECT_NEAR(seen.outline[0].y, 0.3, 1e-6);
  EXPECT_NEAR(seen.velocity_covariance.xx, in_world.velocity_covariance.yy, 1e-9);
  EXPECT_NEAR(seen.position_covariance.yy, in_world.position_covariance.xx, 1e-9);
}

// From the left, 8 m ahead, at 4 m/s to the right: its front is seen, of its length at first only a part.
TEST(Tracker, WhatComesIntoViewKeepsSpeedAndPlaceOfItsNearSide) {
  const GroundSeenFree world{wide_world()};
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  for (int step{0}; step < 10; ++step) {
    const double front{4.5 - 0.4 * step};
    const double rear{std::min(front + 4, 5.0)};
    Cluster car{box_between({8, front}, {9.5, rear}, {0, -4}, 0.5)};
    car.yaw_rad = -90 * degree;
    std::swap(car.length_m, car.width_m);
    car.is_cut_left = rear == 5;
    update(tracker, world, {car}, 0.1);
    const Obstacle seen{report_of(tracker).at(0)};
    if (step < 3) continue;
    ASSERT_TRUE(seen.moving) << step;
    EXPECT_EQ(seen.id, 1);
    EXPECT_NEAR(seen.vy_mps, -4, 0.15) << "its middle is only half as fast, step " << step;
    EXPECT_NEAR(seen.y_m - seen.length_m / 2, front, 0.1) << step;
    EXPECT_EQ(std::isinf(seen.length_sigma_m), car.is_cut_left) << step;
  }
}

TEST(Tracker, ATurningCarHasAYawRateAndCoastsAlongItsCircle) {
  const GroundSeenFree world{wide_world()};
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  const auto angle_at = [](int step) { return -1.2 + 0.05 * step; };
  const auto place_at = [&](int step) {
    return Point2{12 + 10 * std::cos(angle_at(step)), 10 * std::sin(angle_at(step))};
  };
  EXPECT_EQ(Obstacle{}.yaw_rate_radps, 0);
  for (int step{0}; step < 20; ++step) {
    const Point2 at{place_at(step)};
    const Point2 velocity{-5 * std::sin(angle_at(step)), 5 * std::cos(angle_at(step))};
    Cluster car{blob_at(at.x, at.y, velocity)};
    car.velocity_covariance = {0.01, 0, 0.01};
    update(tracker, world, {car}, 0.1);
    EXPECT_TRUE(step >= 2 || report_of(tracker).at(0).yaw_rate_radps == 0) << "not surely yet";
  }
  EXPECT_NEAR(report_of(tracker).at(0).yaw_rate_radps, 0.5, 0.15);
  EXPECT_LT(report_of(tracker).at(0).yaw_sigma_rad, 0.1);
  for (int step{20}; step < 26; ++step) update(tracker, world, {}, 0.1);
  const Obstacle unseen{report_of(tracker).at(0)};
  ASSERT_TRUE(unseen.coasting);
  const Point2 straight{place_at(19).x - 5 * std::sin(angle_at(19)) * 0.6,
                        place_at(19).y + 5 * std::cos(angle_at(19)) * 0.6};
  const double from_circle{std::hypot(unseen.x_m - place_at(25).x, unseen.y_m - place_at(25).y)};
  EXPECT_NEAR(std::hypot(unseen.x_m - 12, unseen.y_m), 10, 0.3) << "it coasts along the circle";
  EXPECT_LT(from_circle, 0.6 * std::hypot(straight.x - place_at(25).x, straight.y - place_at(25).y));
}

TEST(MotionState, KeepsTheCovarianceOfTheVelocity) {
  MotionState state{{1, 2}, 0.1, {3, 4}, {0.5, 0.2, 0.4}};
  EXPECT_EQ(state.velocity_covariance().xx, 0.5);
  EXPECT_EQ(state.velocity_covariance().xy, 0.2);
  EXPECT_EQ(state.velocity_covariance().yy, 0.4);
}

TEST(TrackedBox, GrowsByThreeTenthsOfWhatIsSeenOfItsFarSide) {
  const auto view_to = [](double far_m) {
    return BoxView{box_between({8, -1}, {far_m, 1}, {}, 0.5), 0, {}, PaintedObstacles::rig()};
  };
  TrackedBox box;
  box.begin(view_to(9.5), 0, {8, 0});
  EXPECT_NEAR(box.extent_m(0), 1.5, 1e-9);
  box.update(view_to(10.5), {8, 0});
  EXPECT_NEAR(box.extent_m(0), 1.8, 1e-9);
}

TEST(Tracker, WhatStandsHasNoYawRateAndAnUnknownSize) {
  TrackedBlobs run;
  for (int step{0}; step < 5; ++step) run.update({blob_at(3, 0)}, 0.1);
  const Obstacle seen{run.report().at(0)};
  EXPECT_EQ(seen.yaw_rate_radps, 0);
  EXPECT_TRUE(std::isinf(seen.length_sigma_m));
  EXPECT_TRUE(std::isinf(seen.width_sigma_m));
}

// For a moment only, as a cluster that is followed wrongly does.
TEST(Tracker, WhatIsSaidToMoveByFewFramesStandsWhenItIsNotSeen) {
  const GroundSeenFree world{wide_world()};
  Tracker tracker{plain_config(), PaintedObstacles::rig()};
  Cluster blob{blob_at(3, 0, {5, 0})};
  blob.velocity_covariance = {0.16, 0, 0.16};
  for (int step{0}; step < 3; ++step) update(tracker, world, {blob}, 0.01);
  EXPECT_TRUE(report_of(tracker).at(0).moving);
  Tracker brief{plain_config(), PaintedObstacles::rig()};
  blob.pixels = 400;
  for (int step{0}; step < 3; ++step) update(brief, world, {blob}, 0.01);
  update(brief, world, {}, 0.005);
  const Obstacle unseen{report_of(brief).at(0)};
  EXPECT_TRUE(unseen.coasting);
  EXPECT_FALSE(unseen.moving);
}

}  // namespace
}  // namespace stereogrid::test
