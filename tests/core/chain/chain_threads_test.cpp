// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Whole drives: every back end and every number of threads gives the same results, bit for bit.
#include <thread>

#include "chain_run.hpp"

namespace stereogrid::test {
namespace {

TEST(ChainThreads, CpuEqualsReferenceOnAnyNumberOfThreads) {
  for (const char* name : {"paper", "default"}) {
    Config config{preset(name)};
    config.matching.window_px = 7;
    config.matching.disparities = 32;
    config.matching.speckle_px = config.matching.road_speckle_px = 10;
    config.grid.length_m = 8;
    config.grid.width_m = 6;
    config.filter.speeds_mps = {1.25, 2.5, 3.9};
    const char* scene{"street?width=123&height=77&frames=3"};
    Drive reference{scene, config, 1, BackEnd::reference};
    Drive one{scene, config, 1};
    Drive two{scene, config, 2};
    for (std::size_t i{0}; i < 3; ++i) {
      const FrameResult& expected{reference.step(i)};
      expect_equal(expected, one.step(i));
      expect_equal(expected, two.step(i));
    }
  }
}

TEST(ChainThreads, ResultsAreTheSameOnAnyNumberOfThreads) {
  for (const MatchingMethod method : {MatchingMethod::correlation, MatchingMethod::semi_global}) {
    Config config{preset("default")};
    config.matching.method = method;
    const char* scene{"street?width=211&height=103&frames=4"};
    for (const int threads : {2, 3, 7}) {
      Drive one{scene, config, 1};
      Drive several{scene, config, threads};
      for (std::size_t i{0}; i < 4; ++i) {
        SCOPED_TRACE(testing::Message() << threads << " threads, frame " << i);
        const FrameResult& result{several.step(i)};
        expect_equal(one.step(i), result);
        EXPECT_GT(result.obstacle_density, 0.05);
        EXPECT_GT(result.road_density, 0.05);
      }
    }
  }
}

TEST(ChainThreads, PipelinesInTwoThreadsDoNotDisturbEachOther) {
  const char* scene{"street?width=211&height=103&frames=4"};
  Config other{preset("paper")};
  other.matching.method = MatchingMethod::semi_global;
  Drive alone{scene};
  Drive other_alone{scene, other};
  Drive beside{scene};
  Drive other_beside{scene, other};
  for (std::size_t i{0}; i < 4; ++i) {
    const FrameResult* others{nullptr};
    std::thread thread{[&] { others = &other_beside.step(i); }};
    const FrameResult& result{beside.step(i)};
    thread.join();
    SCOPED_TRACE(testing::Message() << "frame " << i);
    expect_equal(alone.step(i), result);
    expect_equal(other_alone.step(i), *others);
  }
}

}  // namespace
}  // namespace stereogrid::test
