// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// No recorded drive has a drop, blurred images included.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::test {
namespace {

std::filesystem::path data_folder() {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  return named ? std::filesystem::path{named} : std::filesystem::path{STEREOGRID_SOURCE_DIR} / "../shared/data";
}

// Mean of 5 × 5 pixels: a blur of 1.4 px.
Image<std::uint8_t> blurred(const Image<std::uint8_t>& sharp) {
  constexpr int reach{2};
  Image<std::uint8_t> soft{sharp};
  for (int v{reach}; v < sharp.height() - reach; ++v) {
    for (int u{reach}; u < sharp.width() - reach; ++u) {
      int sum{0};
      for (int dv{-reach}; dv <= reach; ++dv) {
        for (int du{-reach}; du <= reach; ++du) sum += sharp(u + du, v + dv);
      }
      soft(u, v) = static_cast<std::uint8_t>(sum / 25);
    }
  }
  return soft;
}

class DropsOfDrives : public testing::TestWithParam<const char*> {};

TEST_P(DropsOfDrives, AreNone) {
  const std::filesystem::path folder{data_folder() / GetParam()};
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  io::InputArguments arguments;
  arguments.paths = {folder};
  const auto drive{io::open_recording(arguments)};
  for (const bool is_soft : {false, true}) {
    Pipeline pipeline{preset("default"), drive->rig(), {.stages = false}};
    int drops{0};
    for (std::size_t i{0}; i < drive->size(); ++i) {
      StereoFrame frame{drive->load(i)};
      if (is_soft) {
        frame.left = blurred(frame.left);
        frame.right = blurred(frame.right);
      }
      drops += std::ranges::any_of(pipeline.process(frame).obstacles,
                                   [](const Obstacle& one) { return one.kind == ObstacleKind::drop && one.confirmed; });
    }
    EXPECT_EQ(drops, 0) << (is_soft ? "blurred" : "sharp");
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, DropsOfDrives,
                         testing::Values("kitti_odo04", "kitti_raw0009", "kitti_raw0001", "kitti_adas21"),
                         [](const auto& drive) { return std::string{drive.param}; });

}  // namespace
}  // namespace stereogrid::test
