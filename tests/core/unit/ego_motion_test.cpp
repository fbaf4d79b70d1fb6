// SPDX-License-Identifier: Apache-2.0
#include "motion/ego_motion.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace stereogrid::test {
namespace {

using ::testing::HasSubstr, ::testing::Optional;

constexpr double degree{3.14159265358979323846 / 180};
constexpr double dt_s{0.1};

void expect_near(const Pose2& actual, const Pose2& expected, double tolerance = 1e-9) {
  EXPECT_NEAR(actual.x_m, expected.x_m, tolerance);
  EXPECT_NEAR(actual.y_m, expected.y_m, tolerance);
  EXPECT_NEAR(std::remainder(actual.yaw_rad - expected.yaw_rad, 360 * degree), 0, tolerance);
}

/// Poses of a drive at 13 m/s that turns by 10°/s.
class Drive {
 public:
  explicit Drive(const MotionConfig& config = {}) : ego_motion{config} {}

  EgoMotion::Placing step(double seconds = dt_s) {
    true_world_from_vehicle = true_world_from_vehicle * Pose2{13 * seconds, 0, 10 * degree * seconds};
    return ego_motion.place(input_from_world * true_world_from_vehicle, seconds);
  }
  EgoMotion::Placing begin() { return ego_motion.place(input_from_world * true_world_from_vehicle, 0); }

  EgoMotion ego_motion;
  Pose2 input_from_world{100, -50, 2};
  Pose2 true_world_from_vehicle{};
};

TEST(EgoMotion, WorldBeginsAtTheFirstFrame) {
  Drive drive;
  expect_near(drive.begin().world_from_vehicle, {});
  for (int i{0}; i < 30; ++i) {
    const auto placing{drive.step(i == 7 ? 0.7 : dt_s)};
    EXPECT_EQ(placing.warning, std::nullopt);
    expect_near(placing.world_from_vehicle, drive.true_world_from_vehicle);
  }
}

TEST(EgoMotion, WorldBeginsWhereItIsSet) {
  Drive drive;
  drive.ego_motion.start_at({7, 8, 1});
  expect_near(drive.begin().world_from_vehicle, {7, 8, 1});
  const auto second{drive.step()};
  expect_near(second.world_from_vehicle, Pose2{7, 8, 1} * drive.true_world_from_vehicle);
}

TEST(EgoMotion, WorldCanBeThatOfThePoses) {
  Drive drive;
  drive.ego_motion = EgoMotion{{}, true};
  expect_near(drive.begin().world_from_vehicle, drive.input_from_world);
  const auto second{drive.step()};
  expect_near(second.world_from_vehicle, drive.input_from_world * drive.true_world_from_vehicle);
  drive.ego_motion.restart();
  const auto third{drive.step()};
  expect_near(third.world_from_vehicle, drive.input_from_world * drive.true_world_from_vehicle);
}

class Jump : public ::testing::TestWithParam<Pose2> {};

TEST_P(Jump, MovesThePosesAndNotTheVehicle) {
  Drive drive;
  static_cast<void>(drive.begin());
  for (int i{0}; i < 5; ++i) static_cast<void>(drive.step());
  drive.input_from_world = drive.input_from_world * GetParam();
  const auto jumped{drive.step()};
  EXPECT_THAT(jumped.warning, Optional(HasSubstr("pose jump of")));
  // motion is constant here, so that carrying it on is exact
  expect_near(jumped.world_from_vehicle, drive.true_world_from_vehicle);
  for (int i{0}; i < 5; ++i) {
    const auto placing{drive.step()};
    EXPECT_EQ(placing.warning, std::nullopt) << i;
    expect_near(placing.world_from_vehicle, drive.true_world_from_vehicle);
  }
}

INSTANTIATE_TEST_SUITE_P(, Jump,
                         ::testing::Values(Pose2{5, 0, 0}, Pose2{0, -1, 0}, Pose2{1000, 2000, 1}, Pose2{-1.3, 0, 0},
                                           Pose2{0, 0, 5 * degree}, Pose2{0, 0, 180 * degree}));

// From middle to middle of two intervals, a mean rate changes by 12 m/s² and 180°/s² at most; steps of 0.3 m and 1° are
// noise.
TEST(EgoMotion, AJumpBeginsWhereNoVehicleGetsTo) {
  const double between_s2{dt_s * (dt_s + dt_s) / 2};
  const double most_m{0.3 + 12 * between_s2};
  const double most_rad{(1 + 180 * between_s2) * degree};
  for (const auto& [step, is_jump] : {std::pair{Pose2{0.99 * most_m, 0, 0}, false},
                                      {Pose2{1.01 * most_m, 0, 0}, true},
                                      {Pose2{0, 0, 0.99 * most_rad}, false},
                                      {Pose2{0, 0, 1.01 * most_rad}, true}}) {
    EgoMotion motion{{}};
    Pose2 pose{};
    static_cast<void>(motion.place(pose, 0));
    for (int i{0}; i < 3; ++i) static_cast<void>(motion.place(pose = pose * Pose2{1.3, 0, 0}, dt_s));
    const auto placing{motion.place(pose * Pose2{1.3, 0, 0} * step, dt_s)};
    EXPECT_EQ(placing.status == FrameStatus::pose_jump, is_jump) << step.x_m << " " << step.yaw_rad;
  }
}

TEST(EgoMotion, AnOutlierJumpsForthAndBack) {
  Drive drive;
  static_cast<void>(drive.begin());
  for (int i{0}; i < 5; ++i) static_cast<void>(drive.step());
  const Pose2 right{drive.input_from_world};
  drive.input_from_world = right * Pose2{3, 3, 0};
  EXPECT_THAT(drive.step().warning, Optional(HasSubstr("jump of")));
  drive.input_from_world = right;
  EXPECT_THAT(drive.step().warning, Optional(HasSubstr("jump of")));
  const auto after{drive.step()};
  EXPECT_EQ(after.warning, std::nullopt);
  expect_near(after.world_from_vehicle, drive.true_world_from_vehicle);
}

TEST(EgoMotion, SaysHowFar) {
  Drive drive;
  static_cast<void>(drive.begin());
  for (int i{0}; i < 3; ++i) static_cast<void>(drive.step());
  const Pose2 now{drive.true_world_from_vehicle};
  const Pose2 next{now * Pose2{1.3, 0, degree}};
  const Pose2 jump{3, 4, -2 * degree};
  const auto placing{drive.ego_motion.place(drive.input_from_world * next * jump, dt_s)};
  EXPECT_THAT(placing.warning, Optional(HasSubstr("jump of 5.0 m and 2.0°")));
}

TEST(EgoMotion, BrakingAndSwervingAreNoJumps) {
  EgoMotion ego_motion{MotionConfig{}};
  Pose2 pose;
  double speed_mps{20};
  double yaw_rate_radps{0};
  static_cast<void>(ego_motion.place(pose, 0));
  for (int i{0}; i < 40; ++i) {
    speed_mps = std::max(0.0, speed_mps - 10 * dt_s);
    yaw_rate_radps = 30 * degree * std::sin(i * 0.5);
    pose = pose * Pose2{speed_mps * dt_s, 0.1 * (i % 2), yaw_rate_radps * dt_s};
    EXPECT_EQ(ego_motion.place(pose, dt_s).warning, std::nullopt) << i;
  }
}

TEST(EgoMotion, ImpossibleSpeedIsNoticedAtTheSecondFrame) {
  EgoMotion ego_motion{MotionConfig{}};
  static_cast<void>(ego_motion.place(Pose2{}, 0));
  const auto placing{ego_motion.place(Pose2{20, 0, 0}, dt_s)};
  EXPECT_THAT(placing.warning, Optional(HasSubstr("20.0 m")));
  expect_near(placing.world_from_vehicle, {});
}

// Poses that agree with each other are accepted again after a drive that begins with a jump.
TEST(EgoMotion, IsNotLockedOut) {
  EgoMotion ego_motion{MotionConfig{}};
  static_cast<void>(ego_motion.place(Pose2{}, 0));
  EXPECT_EQ(ego_motion.place(Pose2{5, 0, 0}, dt_s).warning, std::nullopt) << "50 m/s may be";
  EXPECT_THAT(ego_motion.place(Pose2{5, 0, 0}, dt_s).warning, Optional(HasSubstr("jump of")));
  for (int i{0}; i < 3; ++i) EXPECT_EQ(ego_motion.place(Pose2{5, 0, 0}, dt_s).warning, std::nullopt);
}

TEST(EgoMotion, FramesWithoutAPoseAreBridged) {
  Drive drive;
  static_cast<void>(drive.begin());
  for (int i{0}; i < 3; ++i) static_cast<void>(drive.step());
  for (int i{0}; i < 2; ++i) {
    drive.true_world_from_vehicle = drive.true_world_from_vehicle * Pose2{1.3, 0, degree};
    const auto placing{drive.ego_motion.place(std::nullopt, dt_s)};
    EXPECT_EQ(placing.warning.value_or(""), i == 0 ? "no pose: the last motion continues" : "");
    expect_near(placing.world_from_vehicle, drive.true_world_from_vehicle);
  }
  const auto again{drive.step()};
  EXPECT_EQ(again.warning, std::nullopt);
  expect_near(again.world_from_vehicle, drive.true_world_from_vehicle);
}

TEST(EgoMotion, WithoutAnyPoseTheVehicleStands) {
  EgoMotion ego_motion{MotionConfig{}};
  EXPECT_THAT(ego_motion.place(std::nullopt, 0).warning, Optional(HasSubstr("assumed to be static")));
  const auto second{ego_motion.place(std::nullopt, dt_s)};
  EXPECT_EQ(second.warning, std::nullopt);
  expect_near(second.world_from_vehicle, {});
  expect_near(ego_motion.place(Pose2{3, 4, 1}, dt_s).world_from_vehicle, {});
}

TEST(EgoMotion, ReportsTheSameAsStatusAndText) {
  Drive drive;
  EXPECT_FALSE(drive.begin().status);
  EXPECT_FALSE(drive.step().status);
  for (int i{0}; i < 3; ++i) EXPECT_EQ(drive.ego_motion.place(std::nullopt, dt_s).status, FrameStatus::pose_missing);
  drive.input_from_world = Pose2{900, 0, 0};
  EXPECT_EQ(drive.step().status, FrameStatus::pose_jump);
  EXPECT_FALSE(drive.step().status);
}

TEST(EgoMotion, WhereThereNeverWasAPoseNoneIsMissing) {
  EgoMotion ego_motion{MotionConfig{}};
  EXPECT_EQ(ego_motion.place(std::nullopt, 0).status, FrameStatus::pose_missing) << "worth a word at the start";
  for (int i{0}; i < 3; ++i) EXPECT_FALSE(ego_motion.place(std::nullopt, dt_s).status);
  EXPECT_FALSE(ego_motion.place(Pose2{3, 4, 1}, dt_s).status);
  EXPECT_EQ(ego_motion.place(std::nullopt, dt_s).status, FrameStatus::pose_missing);
}

// A clock that stutters: noise of a pose within a nanosecond is not extrapolated as motion.
TEST(EgoMotion, NextToNoTimeGivesNoMotion) {
  for (const bool notices : {true, false}) {
    MotionConfig config;
    config.detect_jumps = notices;
    Drive drive{config};
    static_cast<void>(drive.begin());
    for (int i{0}; i < 3; ++i) static_cast<void>(drive.step());
    const Pose2 noise{0.02, 0, 0.001};
    static_cast<void>(drive.ego_motion.place(drive.input_from_world * drive.true_world_from_vehicle * noise, 1e-9));
    drive.true_world_from_vehicle = drive.true_world_from_vehicle * Pose2{1.3, 0, degree};
    expect_near(drive.ego_motion.place(std::nullopt, dt_s).world_from_vehicle, drive.true_world_from_vehicle, 0.03);
    EXPECT_EQ(drive.step().warning, std::nullopt);
  }
}

TEST(EgoMotion, AfterARestartThePlaceFollowsThePoseHoweverFar) {
  Drive drive;
  static_cast<void>(drive.begin());
  for (int i{0}; i < 3; ++i) static_cast<void>(drive.step());
  drive.ego_motion.restart();
  drive.true_world_from_vehicle = drive.true_world_from_vehicle * Pose2{5000, 300, 2};
  const auto placing{drive.step()};
  EXPECT_FALSE(placing.status);
  expect_near(placing.world_from_vehicle, drive.true_world_from_vehicle, 1e-6);
  EXPECT_FALSE(drive.step().status);
  expect_near(drive.step().world_from_vehicle, drive.true_world_from_vehicle, 1e-6);
}

TEST(EgoMotion, AfterARestartWithoutAPoseTheVehicleStands) {
  Drive drive;
  static_cast<void>(drive.begin());
  const Pose2 last{drive.step().world_from_vehicle};
  drive.ego_motion.restart();
  const auto placing{drive.ego_motion.place(std::nullopt, 0)};
  EXPECT_THAT(placing.warning, Optional(HasSubstr("assumed to be static")));
  expect_near(drive.ego_motion.place(std::nullopt, dt_s).world_from_vehicle, last);
}

TEST(EgoMotion, AfterARestartItCanBeSetWhereTheVehicleIs) {
  Drive drive;
  static_cast<void>(drive.begin());
  static_cast<void>(drive.step());
  drive.ego_motion.restart();
  drive.ego_motion.start_at({7, 8, 1});
  expect_near(drive.step().world_from_vehicle, {7, 8, 1});
}

TEST(EgoMotion, MayFollowJumps) {
  MotionConfig config;
  config.detect_jumps = false;
  EgoMotion ego_motion{config};
  static_cast<void>(ego_motion.place(Pose2{}, 0));
  const auto placing{ego_motion.place(Pose2{500, 0, 1}, dt_s)};
  EXPECT_EQ(placing.warning, std::nullopt);
  expect_near(placing.world_from_vehicle, {500, 0, 1});
}

}  // namespace
}  // namespace stereogrid::test
