// SPDX-License-Identifier: Apache-2.0
//
// Clocks that leap, stand or step back: frames of a wall that stands 9 m ahead, with whatever stamps.
#include "hostile_run.hpp"
#include "pipeline/frame_input.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

using ::testing::Contains, ::testing::ElementsAre, ::testing::Field, ::testing::HasSubstr, ::testing::IsEmpty;

constexpr std::int64_t second_ns{1'000'000'000};
constexpr std::int64_t frame_ns{second_ns / 10};
constexpr std::int64_t ten_days_ns{864'000 * second_ns};

class HostileClock : public ::testing::TestWithParam<BackEnd> {
 protected:
  // Frames a tenth of a second apart, the first of them at `stamp_ns`.
  const FrameResult& drive(std::int64_t stamp_ns, int frames) {
    for (int i{0}; i < frames; ++i) result_ = &wall_.step(stamp_ns + i * frame_ns);
    return *result_;
  }

  Wall wall_{GetParam()};
  const FrameResult* result_{nullptr};
};

INSTANTIATE_TEST_SUITE_P(BackEnds, HostileClock, ::testing::ValuesIn(back_ends()));

TEST_P(HostileClock, AClockThatIsSetAfterBootIsAGap) {
  drive(second_ns, 5);
  const FrameResult& result{drive(1'790'000'000 * second_ns, 1)};
  EXPECT_THAT(leaps_of(result), ElementsAre(FrameStatus::clock_gap));
  EXPECT_THAT(result.warnings, Contains(Field(&Warning::text, HasSubstr("motion.gap_max_s"))));
  EXPECT_THAT(leaps_of(drive(1'790'000'000 * second_ns + frame_ns, 4)), IsEmpty());
  EXPECT_THAT(result_->obstacles, ::testing::Not(IsEmpty()));
}

TEST_P(HostileClock, AnyGapIsSurvivedWithPosesAndWithout) {
  // decisions are shared by all back ends; the plain loops are slow
  const std::vector<double> gaps_s{GetParam() == BackEnd::reference ? std::vector{9e9}
                                                                    : std::vector{6.0, 8e6, 1e9, 9e9}};
  for (const double gap_s : gaps_s) {
    for (const bool has_poses : {false, true}) {
      Wall wall{GetParam()};
      wall.has_poses = has_poses;
      for (int i{0}; i < 3; ++i) static_cast<void>(wall.step(i * frame_ns));
      const auto stamp_ns = static_cast<std::int64_t>(gap_s * 1e9);
      EXPECT_THAT(leaps_of(wall.step(stamp_ns)), ElementsAre(FrameStatus::clock_gap));
      EXPECT_THAT(leaps_of(wall.step(stamp_ns + frame_ns)), IsEmpty());
    }
  }
}

TEST_P(HostileClock, ThereAndBackOverAllStamps) {
  constexpr std::int64_t first_ns{std::numeric_limits<std::int64_t>::min()};
  constexpr std::int64_t last_ns{std::numeric_limits<std::int64_t>::max()};
  drive(first_ns, 2);
  EXPECT_THAT(leaps_of(drive(last_ns, 1)), ElementsAre(FrameStatus::clock_gap));
  EXPECT_THAT(result_->warnings, Contains(Field(&Warning::text, HasSubstr("18446744073."))));
  EXPECT_THAT(leaps_of(drive(first_ns, 1)), ElementsAre(FrameStatus::clock_stepped_back));
  EXPECT_THAT(result_->warnings, Contains(Field(&Warning::text, HasSubstr("stepped back by 18446744073."))));
}

TEST_P(HostileClock, AFrameTenDaysAheadCostsTheMemoryTwiceAndNoMore) {
  drive(0, 4);
  EXPECT_THAT(leaps_of(drive(ten_days_ns, 1)), ElementsAre(FrameStatus::clock_gap));
  EXPECT_THAT(leaps_of(drive(4 * frame_ns, 1)), ElementsAre(FrameStatus::clock_stepped_back));
  EXPECT_THAT(result_->warnings, Contains(Field(&Warning::text, HasSubstr("stepped back by 863999.600 s"))));
  EXPECT_THAT(leaps_of(drive(5 * frame_ns, 3)), IsEmpty());
}

TEST_P(HostileClock, AStampTwiceIsRefusedAndNothingElse) {
  Wall undisturbed{GetParam()};
  drive(0, 3);
  EXPECT_THROW(drive(2 * frame_ns, 1), InputError);
  EXPECT_THROW(drive(2 * frame_ns, 1), InputError);
  wall_.remove_refused(2);
  const FrameResult& result{drive(3 * frame_ns, 1)};
  for (int i{0}; i < 4; ++i) result_ = &undisturbed.step(i * frame_ns);
  expect_equal(result, *result_);
  EXPECT_THAT(leaps_of(result), IsEmpty());
}

// After a leap all is as in a new pipeline, but ids of obstacles are new.
TEST_P(HostileClock, AfterALeapAllIsNew) {
  for (const std::int64_t leap_ns : {-second_ns, 7 * second_ns}) {
    Wall old{GetParam()};
    std::int64_t last_id{0};
    for (int i{0}; i < 6; ++i) {
      for (const Obstacle& obstacle : old.step(i * frame_ns).obstacles) last_id = std::max(last_id, obstacle.id);
    }
    ASSERT_GT(last_id, 0);
    Wall fresh{GetParam()};
    fresh.number = old.number;
    for (int i{0}; i < 4; ++i) {
      SCOPED_TRACE(i);
      const FrameResult& actual{old.step(5 * frame_ns + leap_ns + i * frame_ns)};
      FrameResult expected{fresh.step(i * frame_ns)};
      for (Obstacle& obstacle : expected.obstacles) obstacle.id += last_id;  // the first id is 1
      expect_equal(actual, expected);
      for (const Obstacle& obstacle : actual.obstacles) EXPECT_GT(obstacle.id, last_id);
    }
  }
}

TEST_P(HostileClock, ResetDoesTheSameByHand) {
  drive(0, 5);
  wall_.pipeline.reset();
  Wall fresh{GetParam()};
  fresh.number = wall_.number;
  for (int i{0}; i < 3; ++i) {
    // the same stamps again
    const FrameResult& actual{wall_.step(i * frame_ns)};
    const FrameResult& expected{fresh.step(i * frame_ns)};
    EXPECT_THAT(leaps_of(actual), IsEmpty());
    EXPECT_EQ(actual.world.occupancy, expected.world.occupancy);
    EXPECT_EQ(actual.world.age_s, expected.world.age_s);
    EXPECT_EQ(actual.world.velocity_x, expected.world.velocity_x);
    EXPECT_EQ(actual.ground, expected.ground);
    EXPECT_EQ(actual.obstacles.size(), expected.obstacles.size());
  }
}

TEST_P(HostileClock, ThePlaceFollowsThePosesOverALeap) {
  wall_.has_poses = true;
  wall_.speed_mps = 5;
  drive(0, 6);
  EXPECT_NEAR(result_->world_from_vehicle.x_m, 2.5, 1e-9);
  wall_.place_m += 400;  // too far for 1 s, but the duration is unknown
  EXPECT_THAT(leaps_of(drive(-second_ns, 1)), ElementsAre(FrameStatus::clock_stepped_back));
  EXPECT_NEAR(result_->world_from_vehicle.x_m, 403, 1e-9);
  EXPECT_THAT(leaps_of(drive(-second_ns + frame_ns, 3)), IsEmpty());
  EXPECT_NEAR(result_->world_from_vehicle.x_m, 404.5, 1e-9);
}

TEST_P(HostileClock, WithoutPosesTheVehicleStaysWhereItWas) {
  wall_.has_poses = true;
  wall_.speed_mps = 5;
  drive(0, 6);
  wall_.has_poses = false;
  drive(20 * second_ns, 3);
  EXPECT_NEAR(result_->world_from_vehicle.x_m, 2.5, 1e-9);
  EXPECT_THAT(leaps_of(*result_), ElementsAre(FrameStatus::pose_missing));
}

TEST_P(HostileClock, TheLongestGapThatIsNoneIsASetting) {
  Config config{small_config()};
  config.motion.gap_max_s = 3600;
  for (const bool has_poses : {false, true}) {
    Wall patient{GetParam(), config};
    patient.has_poses = has_poses;
    static_cast<void>(patient.step(0));
    for (const std::int64_t stamp_ns : {frame_ns, 2 * frame_ns, 3600 * second_ns, 7199 * second_ns}) {
      EXPECT_THAT(leaps_of(patient.step(stamp_ns)), IsEmpty());
    }
  }
}

TEST_P(HostileClock, NextToNoTimeBetweenFramesIsSurvived) {
  wall_.has_poses = true;
  wall_.speed_mps = 5;
  for (int i{0}; i < 5; ++i) {
    drive(i * second_ns, 3);
    drive(i * second_ns + 2 * frame_ns + 1, 2);
  }
  EXPECT_THAT(leaps_of(drive(6 * second_ns, 1)), IsEmpty());
}

TEST(FrameClock, AGapBeginsBeyondTheLargestInterval) {
  for (const auto& [step_ns, is_gap] : {std::pair{second_ns, false}, {second_ns + 1, true}}) {
    FrameClock clock;
    EXPECT_EQ(clock.tick(0, 1).dt_s, 0) << "a first frame";
    EXPECT_EQ(clock.tick(step_ns, 1).leap.has_value(), is_gap) << step_ns;
  }
  FrameClock clock;
  EXPECT_FALSE(clock.stands_still(0));
  static_cast<void>(clock.tick(0, 1));
  EXPECT_TRUE(clock.stands_still(0));
  EXPECT_FALSE(clock.stands_still(1));
  clock.reset();
  EXPECT_FALSE(clock.stands_still(0));
}

}  // namespace
}  // namespace stereogrid::test
