// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Ground that no frame of a recorded drive has observed is unknown to the filter, too.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "never_observed.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::test {
namespace {

std::filesystem::path data_folder() {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  return named ? std::filesystem::path{named} : std::filesystem::path{STEREOGRID_SOURCE_DIR} / "../shared/data";
}

class NeverObservedOfDrives : public testing::TestWithParam<const char*> {};

TEST_P(NeverObservedOfDrives, IsUnknownOrMoves) {
  const std::filesystem::path folder{data_folder() / GetParam()};
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  io::InputArguments arguments;
  arguments.paths = {folder};
  const auto drive{io::open_recording(arguments)};
  for (const char* const name : {"default", "robot"}) {
    for (const double finer : {1.0, 2.0}) {
      Config config{preset(name)};
      config.grid.cell_size_m /= finer;
      config.grid.length_m /= finer;
      config.grid.width_m /= finer;
      Pipeline pipeline{config, drive->rig(), {.stages = false}};
      NeverObservedCells cells;
      for (std::size_t i{0}; i < drive->size(); ++i) cells.add(pipeline.process(drive->load(i)));
      EXPECT_EQ(cells.unfounded(), 0) << name << ", cells of " << config.grid.cell_size_m << " m";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, NeverObservedOfDrives,
                         testing::Values("kitti_odo04", "kitti_raw0009", "kitti_raw0001", "kitti_adas21", "euroc_v101"),
                         [](const auto& drive) { return std::string{drive.param}; });

}  // namespace
}  // namespace stereogrid::test
