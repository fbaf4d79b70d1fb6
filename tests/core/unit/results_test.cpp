// SPDX-License-Identifier: Apache-2.0
//
// Results of the caller's own: nothing of them is read, and all of them is written.
#include <new>

#include "hostile_run.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

class CallersResult : public ::testing::TestWithParam<BackEnd> {
 protected:
  PipelineOptions options_{.back_end = GetParam(), .threads = 2};
};

// As a caller does who keeps the last result while the next frame is processed.
TEST_P(CallersResult, IsThatOfThePipeline) {
  options_.horizons_s = {0.5};
  Wall own{options_};
  Wall callers{options_};
  FrameResult now;
  FrameResult before;
  FrameResult copy_of_before;
  for (int i{0}; i < 6; ++i) {
    SCOPED_TRACE(i);
    StereoFrame frame{callers.frame(i * 100'000'000)};
    if (i == 3) frame.right.fill(7);  // nothing matches: all is unknown
    ++callers.number;
    const FrameResult& expected{own.pipeline.process(frame)};
    std::swap(now, before);
    callers.pipeline.process(frame, now);
    expect_equal(now, expected);
    EXPECT_EQ(now.status, expected.status);
    EXPECT_EQ(now.warnings, expected.warnings);
    EXPECT_EQ(now.predictions.at(0).occupancy, expected.predictions.at(0).occupancy);
    EXPECT_EQ(now.predictions.at(0).world_occupancy, expected.predictions.at(0).world_occupancy);
    EXPECT_EQ(callers.pipeline.world_grid(), expected.world.geometry);
    if (i > 0) expect_equal(before, copy_of_before);
    copy_of_before = now;
  }
}

TEST_P(CallersResult, MayBeOfAnotherPipelineAndHaveBeenMovedFrom) {
  Config other_config{small_config()};
  other_config.grid = {6, 4, 0.25};
  other_config.matching.disparities = 32;
  Wall other{options_, other_config};
  Wall own{options_};
  Wall callers{options_};
  FrameResult result;
  other.pipeline.process(other.frame(0), result);
  for (int i{0}; i < 3; ++i) {
    const StereoFrame frame{callers.frame(i * 100'000'000)};
    ++callers.number;
    callers.pipeline.process(frame, result);
    expect_equal(result, own.pipeline.process(frame));
    const FrameResult taken{std::move(result)};
    EXPECT_FALSE(taken.vehicle.occupancy.empty());
  }
}

TEST_P(CallersResult, StaysAsItWasWhereTheFrameCannotBeUsed) {
  Wall wall{options_};
  FrameResult result;
  wall.pipeline.process(wall.frame(0), result);
  const FrameResult before{result};
  StereoFrame frame{wall.frame(100'000'000)};
  frame.left = {};
  EXPECT_THROW(wall.pipeline.process(frame, result), InputError);
  expect_equal(result, before);
}

TEST_P(CallersResult, HasNoStagesWhereNobodyWantsThem) {
  Wall with{options_};
  options_.stages = false;
  Wall without{options_};
  FrameResult result;
  with.pipeline.process(with.frame(0), result);
  EXPECT_FALSE(result.stages.occupancy.empty());
  for (int i{0}; i < 3; ++i) {
    without.pipeline.process(without.frame(i), result);
    EXPECT_TRUE(result.stages.occupancy.empty());
    EXPECT_TRUE(result.stages.road_disparity.empty());
    EXPECT_FALSE(result.observed.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(, CallersResult, ::testing::ValuesIn(back_ends()),
                         [](const auto& run) { return run.param == BackEnd::cpu ? "cpu" : "reference"; });

// Types that may be saved as raw memory.

struct Full {
  std::int32_t first{0};
  float second{0};
  std::array<double, 2> rest{};
};
struct PaddedWithin {
  float first{0};
  double second{0};
};
struct PaddedAtItsEnd {
  double first{0};
  bool second{false};
};
struct HoldsPadding {
  std::array<PaddedAtItsEnd, 2> both{};
};

TEST(StatePadding, IsNoticed) {
  EXPECT_TRUE(HasNoPadding<Full>);
  EXPECT_TRUE(HasNoPadding<double>);
  EXPECT_FALSE(HasNoPadding<PaddedWithin>);
  EXPECT_FALSE(HasNoPadding<PaddedAtItsEnd>);
  EXPECT_FALSE(HasNoPadding<HoldsPadding>);
  EXPECT_FALSE(HasNoPadding<Ground>) << "is put member by member";
}

// The same numbers in memory that held other things before.
TEST(StatePadding, OfAGroundIsNotSaved) {
  const auto saved = [](unsigned char before) {
    alignas(Ground) std::array<unsigned char, sizeof(Ground)> memory;
    memory.fill(before);
    Ground& ground{*new (memory.data()) Ground{1.5, 0.1, 0.02, true}};
    StateWriter writer;
    writer(ground);
    return writer.bytes();
  };
  EXPECT_EQ(saved(0), saved(255));
}

}  // namespace
}  // namespace stereogrid::test
