// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// submit() and collect(): the results of process(), in a thread of the pipeline.
#include <stdexcept>
#include <utility>
#include <vector>

#include "chain_run.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* scene{"street?width=211&height=103&frames=6"};

TEST(InFlight, GivesTheResultsOfProcessInTurn) {
  Drive expected{scene, small_grid()};
  Drive drive{scene, small_grid()};
  Pipeline& pipeline{drive.pipeline};
  pipeline.submit(drive.scene.load(0));
  for (std::size_t i{0}; i < 6; ++i) {
    if (i + 1 < 6) pipeline.submit(drive.scene.load(i + 1));
    const FrameResult& result{pipeline.collect()};
    SCOPED_TRACE(testing::Message() << "frame " << i);
    expect_equal(expected.step(i), result);
  }
  EXPECT_EQ(pipeline.in_flight(), 0);
  EXPECT_EQ(pipeline.save_state(), expected.pipeline.save_state());
}

TEST(InFlight, ACollectedResultStaysWhileTheNextFramesAreInWork) {
  Drive drive{scene, small_grid()};
  Pipeline& pipeline{drive.pipeline};
  pipeline.submit(drive.scene.load(0));
  const FrameResult& first{pipeline.collect()};
  const FrameResult copy{first};
  pipeline.submit(drive.scene.load(1));
  pipeline.submit(drive.scene.load(2));
  expect_equal(copy, first);
  pipeline.collect();
  pipeline.collect();
}

TEST(InFlight, AFrameThatCannotBeUsedThrowsInItsTurn) {
  Drive expected{scene, small_grid()};
  Drive drive{scene, small_grid()};
  Pipeline& pipeline{drive.pipeline};
  pipeline.submit(drive.scene.load(0));
  StereoFrame other{drive.scene.load(1)};
  other.right = Image<std::uint8_t>{10, 10};
  pipeline.submit(other);
  expect_equal(expected.step(0), pipeline.collect());
  pipeline.submit(drive.scene.load(2));
  EXPECT_THROW(pipeline.collect(), InputError);
  expect_equal(expected.step(2), pipeline.collect());
}

TEST(InFlight, SaysWhatIsDueFirst) {
  Drive drive{scene, small_grid()};
  Pipeline& pipeline{drive.pipeline};
  EXPECT_THROW(pipeline.collect(), std::logic_error);
  pipeline.submit(drive.scene.load(0));
  pipeline.submit(drive.scene.load(1));
  EXPECT_EQ(pipeline.in_flight(), Pipeline::in_flight_max);
  EXPECT_THROW(pipeline.submit(drive.scene.load(2)), std::logic_error);
  EXPECT_THROW(pipeline.process(drive.scene.load(2)), std::logic_error);
  EXPECT_THROW(pipeline.reset(), std::logic_error);
  EXPECT_THROW((void)pipeline.rig(), std::logic_error);
  EXPECT_THROW((void)pipeline.memory_use(), std::logic_error);
  const std::vector<std::byte> none;
  EXPECT_THROW((void)pipeline.save_state(), std::logic_error);
  EXPECT_THROW(pipeline.load_state(none), std::logic_error);
  EXPECT_GT(pipeline.vehicle_grid().nx, 0);
  pipeline.collect();
  pipeline.collect();
  EXPECT_THROW(pipeline.collect(), std::logic_error);
  pipeline.reset();
  const FrameResult& result{pipeline.process(drive.scene.load(2))};
  EXPECT_EQ(result.world.geometry, pipeline.world_grid());
}

TEST(InFlight, APipelineMovesAndEndsWithFramesInWork) {
  Drive expected{scene, small_grid()};
  Drive drive{scene, small_grid()};
  drive.pipeline.submit(drive.scene.load(0));
  drive.pipeline.submit(drive.scene.load(1));
  Pipeline moved{std::move(drive.pipeline)};
  expect_equal(expected.step(0), moved.collect());
  EXPECT_THROW(drive.pipeline.submit(drive.scene.load(2)), std::logic_error);
}

TEST(InFlight, WhatTheThreadHoldsCounts) {
  Drive drive{scene, small_grid()};
  const std::size_t before{drive.pipeline.memory_use().host_bytes};
  drive.pipeline.submit(drive.scene.load(0));
  drive.pipeline.collect();
  EXPECT_GT(drive.pipeline.memory_use().host_bytes, before + 2 * 211 * 103);
}

}  // namespace
}  // namespace stereogrid::test
