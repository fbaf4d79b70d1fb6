// SPDX-License-Identifier: Apache-2.0
//
// Results of the caller's own: nothing of them is read, and all of them is written.
#include <new>

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "hostile_run.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/points.hpp"
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

TEST_P(CallersResult, HasItsGridsBeforeItsObstacles) {
  std::vector<FrameResult> early;
  options_.on_grids = [&early](const FrameResult& result) { early.push_back(result); };
  Wall wall{options_};
  std::size_t obstacles{0};
  for (int i{0}; i < 6; ++i) {
    SCOPED_TRACE(i);
    StereoFrame frame{wall.frame(i * 100'000'000)};
    if (i == 3) frame.right.fill(7);  // nothing matches
    ++wall.number;
    const FrameResult& result{wall.pipeline.process(frame)};
    ASSERT_EQ(early.size(), static_cast<std::size_t>(i) + 1);
    FrameResult& grids{early.back()};
    EXPECT_TRUE(grids.obstacles.empty());
    grids.obstacles = result.obstacles;
    expect_equal(grids, result);
    EXPECT_EQ(grids.world_from_vehicle, result.world_from_vehicle);
    EXPECT_EQ(grids.status, result.status);
    obstacles += result.obstacles.size();
  }
  EXPECT_GT(obstacles, 0u);
  StereoFrame refused{wall.frame(700'000'000)};
  refused.left = {};
  EXPECT_THROW(wall.pipeline.process(refused), InputError);
  EXPECT_EQ(early.size(), 6u);
}

TEST_P(CallersResult, OnGridsCannotCallItsPipeline) {
  Pipeline* inner{nullptr};
  options_.on_grids = [&inner](const FrameResult&) { inner->reset(); };
  Wall wall{options_};
  inner = &wall.pipeline;
  EXPECT_THAT([&wall] { wall.pipeline.process(wall.frame(0)); },
              ::testing::ThrowsMessage<std::logic_error>(::testing::HasSubstr("called by its own on_grids")));
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

const Rig rig{64, 48, 50, 31.5, 20.25, 0.4, 1.3, 0, 0};

FrameResult result_with_images() {
  FrameResult result;
  result.ground = {1.4, 0.02, -0.03};
  result.stages.obstacle_disparity = result.stages.road_disparity = Image<float>{rig.width_px, rig.height_px};
  return result;
}

TEST(Points, LieWhereTheDisparitySays) {
  FrameResult result{result_with_images()};
  result.ground = {1.4, 0, 0};
  result.stages.obstacle_disparity(40, 10) = 4;  // 50 · 0.4 / 4 = 5 m
  result.stages.road_disparity(10, 30) = 2;
  const std::vector<LabelledPoint> points{points_of(result, rig)};
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].label, PointLabel::obstacle);
  EXPECT_NEAR(points[0].x_m, 5, 1e-6);
  EXPECT_NEAR(points[0].y_m, -(40 - 31.5) * 5 / 50, 1e-6);
  EXPECT_NEAR(points[0].z_m, 1.4 - (10 - 20.25) * 5 / 50, 1e-6);
  EXPECT_EQ(points[1].label, PointLabel::road);
  EXPECT_NEAR(points[1].x_m, 10, 1e-6);
  EXPECT_GT(points[1].y_m, 0);
}

TEST(Points, OfTheRoadHaveNoHeight) {
  FrameResult result{result_with_images()};
  const RoadPlane plane{road_plane(rig, result.ground)};
  for (const auto [u, v] : raster(0, rig.width_px, 24, rig.height_px)) {
    result.stages.road_disparity(u, v) = static_cast<float>(std::max(0.0, plane.disparity(u, v)));
  }
  const std::vector<LabelledPoint> points{points_of(result, rig)};
  EXPECT_GT(points.size(), 1000u);
  for (const LabelledPoint& point : points) ASSERT_NEAR(point.z_m, 0, 1e-4);
}

TEST(Points, ThereAreNoneOfAFrameThatCannotBeReliedOn) {
  FrameResult result{result_with_images()};
  result.stages.obstacle_disparity(40, 10) = 4;
  for (const FrameStatus status : {FrameStatus::few_matches, FrameStatus::road_unknown}) {
    result.status = {FrameStatus::pose_missing, status};
    EXPECT_TRUE(points_of(result, rig).empty());
  }
  result.status = {FrameStatus::pose_missing};
  EXPECT_EQ(points_of(result, rig).size(), 1u);
}

TEST(Points, NeedTheStagesAndTheirRig) {
  FrameResult result{result_with_images()};
  Rig larger{rig};
  larger.width_px = 65;
  EXPECT_THROW(static_cast<void>(points_of(result, larger)), InputError);
  result.stages = {};
  EXPECT_THROW(static_cast<void>(points_of(result, rig)), InputError);
}

TEST(ClampedToInt, IsTheCastWhereThatIsDefined) {
  for (const double value : {0.0, -0.0, 0.999, -0.999, 1.0, -1.5, 16383.7, -5e8, 999'999'999.9, -999'999'999.9}) {
    EXPECT_EQ(clamped_to_int(value), static_cast<int>(value)) << value;
  }
}

TEST(ClampedToInt, EndsWhereTwoOfThemAndAnIndexCanStillBeAdded) {
  constexpr double infinity{std::numeric_limits<double>::infinity()};
  for (const double value : {1e9, 2147483647.0, 2147483648.0, 1e300, infinity}) {
    EXPECT_EQ(clamped_to_int(value), far_int) << value;
    EXPECT_EQ(clamped_to_int(-value), -far_int) << value;
  }
  EXPECT_LT(2LL * far_int + 100'000'000, std::numeric_limits<int>::max());
}

TEST(ClampedToInt, OfNoNumberIsZero) {
  EXPECT_EQ(clamped_to_int(std::nan("")), 0);
  EXPECT_EQ(clamped_to_int(std::nan(""), 5), 0);
}

TEST(ClampedToInt, TakesAnotherLimit) {
  EXPECT_EQ(clamped_to_int(4.9, 5), 4);
  EXPECT_EQ(clamped_to_int(5.9, 5), 5);
  EXPECT_EQ(clamped_to_int(-7, 5), -5);
}

}  // namespace
}  // namespace stereogrid::test
