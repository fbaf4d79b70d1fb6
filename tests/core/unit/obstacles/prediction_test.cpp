// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "backend/cpu.hpp"
#include "filter_run.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

Rig small_rig() {
  return {.width_px = 96, .height_px = 64, .focal_px = 80, .cx_px = 48, .cy_px = 32, .baseline_m = 0.3};
}

// A step in which nothing is seen is what a pipeline predicts: a block at 4 m/s is 2 m further after 0.5 s, one
// that stands is where it was.
TEST(Prediction, MovesWhatMovesAndLeavesWhatStands) {
  constexpr int cells{64};
  constexpr double cell_m{0.2};
  Cpu cpu{2};
  FilterRun run{cpu, method_config(FilterModel::joint), {0, 0, cell_m, cells, cells}};
  for (int step{0}; step < 15; ++step) {
    Image<float> observed{scene(cells, 4 + 2 * step, 20, 5, 5)};
    for (int y{45}; y < 50; ++y) std::fill_n(observed.row(y) + 30, 5, 0.98f);
    run.step(observed);
  }
  run.step(Image<float>(cells, cells, 0.5f), 0.5);
  EXPECT_GT(mean_over(run.layers.occupancy, 32 + 11, 21, 3, 3), 0.7);
  EXPECT_LT(mean_over(run.layers.occupancy, 32, 20, 5, 5), 0.4);
  EXPECT_GT(mean_over(run.layers.occupancy, 30, 45, 5, 5), 0.8);
}

TEST(Prediction, ComesWithEveryFrame) {
  Config config;
  config.grid = {6, 6, 0.2};
  Pipeline pipeline{config, small_rig(), {.threads = 1, .horizons_s = {0.5, 1e4}}};
  Pipeline plain{config, small_rig(), {.threads = 1}};
  std::mt19937 generator{4};
  for (int frame{0}; frame < 3; ++frame) {
    StereoFrame pair;
    pair.name = "f";
    pair.stamp_ns = frame * 100'000'000;
    pair.left = pair.right = noise_image(96, 64, generator);
    const FrameResult& result{pipeline.process(pair)};
    const FrameResult& without{plain.process(pair)};
    ASSERT_EQ(result.predictions.size(), 2u);
    EXPECT_EQ(result.predictions[0].occupancy.width(), result.vehicle.geometry.nx);
    EXPECT_EQ(result.predictions[0].world_occupancy.width(), result.world.geometry.nx);
    // after a very long time nothing is known
    for (const float p : result.predictions[1].occupancy) ASSERT_NEAR(p, 0.5, 0.31);
    // and looking ahead changes nothing
    EXPECT_TRUE(result.vehicle.occupancy == without.vehicle.occupancy);
    EXPECT_TRUE(without.predictions.empty());
  }
}

TEST(Prediction, NeedsHorizonsInTheFuture) {
  for (const double horizon_s : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((Pipeline{Config{}, small_rig(), {.horizons_s = {1, horizon_s}}}), ConfigError) << horizon_s;
  }
}

}  // namespace
}  // namespace stereogrid::test
