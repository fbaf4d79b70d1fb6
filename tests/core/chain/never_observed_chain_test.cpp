// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Ground that no frame has observed is unknown to the filter, too, except where a moving obstacle has driven into it.
#include <gtest/gtest.h>

#include <string>

#include "chain_run.hpp"
#include "never_observed.hpp"

namespace stereogrid::test {
namespace {

struct Run {
  const char* scene;
  const char* preset;
  double cell_size_m;
};

class NeverObserved : public testing::TestWithParam<Run> {};

TEST_P(NeverObserved, IsUnknownOrMoves) {
  Config config{preset(GetParam().preset)};
  config.grid.cell_size_m = GetParam().cell_size_m;
  Drive drive{GetParam().scene, config};
  NeverObservedCells cells;
  for (std::size_t i{0}; i < drive.scene.size(); ++i) cells.add(drive.step(i));
  EXPECT_EQ(cells.unfounded(), 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NeverObserved,
                         testing::Values(Run{"corridor?frames=16", "robot", 0.05},
                                         Run{"corridor?frames=12&camera=robot", "robot", 0.1},
                                         Run{"street?frames=12", "default", 0.2},
                                         Run{"street?frames=12&width=320&height=200&focal=256", "robot", 0.05},
                                         Run{"van?frames=25&width=320&height=200&focal=256", "default", 0.2},
                                         Run{"occlusion?frames=12", "default", 0.1}),
                         [](const auto& run) {
                           const std::string scene{run.param.scene};
                           return scene.substr(0, scene.find('?')) + "_" + run.param.preset + std::to_string(run.index);
                         });

}  // namespace
}  // namespace stereogrid::test
