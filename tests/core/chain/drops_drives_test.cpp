// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// No recorded drive has a drop, blurred images included.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

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

struct Frames {
  int all{0};
  int with_drops{0};
};

void process(const FrameSource& drive, bool is_soft, Frames& frames) {
  Pipeline pipeline{preset("default"), drive.rig(), {.stages = false}};
  for (std::size_t i{0}; i < drive.size(); ++i) {
    StereoFrame frame{drive.load(i)};
    // the drive without poses is straight, at 15 m/s
    if (!frame.world_from_vehicle) frame.world_from_vehicle = Pose2{1.5 * static_cast<double>(i), 0, 0};
    if (is_soft) {
      frame.left = blurred(frame.left);
      frame.right = blurred(frame.right);
    }
    ++frames.all;
    frames.with_drops += std::ranges::any_of(pipeline.process(frame).obstacles, [](const Obstacle& one) {
      return one.kind == ObstacleKind::drop && one.confirmed;
    });
  }
}

TEST(DropsOfDrives, AreInOneFrameInAHundredAtMost) {
  if (!std::filesystem::exists(data_folder())) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  Frames frames;
  for (const char* const name : {"kitti_odo04", "kitti_raw0009", "kitti_raw0001", "kitti_adas21"}) {
    io::InputArguments arguments;
    arguments.paths = {data_folder() / name};
    const auto drive{io::open_recording(arguments)};
    for (const bool is_soft : {false, true}) process(*drive, is_soft, frames);
  }
  EXPECT_LE(100 * frames.with_drops, frames.all);
}

}  // namespace
}  // namespace stereogrid::test
