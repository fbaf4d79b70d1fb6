// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Real drives with a calibration that is wrong, against the same drive with the right one.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "ground_drive.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::test {
namespace {

std::filesystem::path data_folder() {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  return named ? std::filesystem::path{named} : std::filesystem::path{STEREOGRID_SOURCE_DIR} / "../shared/data";
}

class GroundDrives : public testing::TestWithParam<const char*> {};

TEST_P(GroundDrives, RecoversWithinFiveFrames) {
  const std::filesystem::path folder{data_folder() / GetParam()};
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  io::InputArguments arguments;
  arguments.paths = {folder};
  const auto drive{io::open_recording(arguments)};
  const std::vector<StereoFrame> frames{frames_of(*drive, 8)};
  const std::vector<Ground> right{grounds_of(frames, drive->rig())};
  for (const WrongBy& by : {WrongBy{1, 0, 0}, WrongBy{-1, 0, 0}, WrongBy{0, 1, 0}, WrongBy{0, 0, 0.1}}) {
    SCOPED_TRACE(testing::Message() << by.pitch_deg << "° " << by.roll_deg << "° " << by.height_m << " m");
    expect_recovered(right, grounds_of(frames, wrong(drive->rig(), by)));
  }
}

TEST_P(GroundDrives, TheGateDoesNotBite) {
  const std::filesystem::path folder{data_folder() / GetParam()};
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  io::InputArguments arguments;
  arguments.paths = {folder};
  const auto drive{io::open_recording(arguments)};
  for (const Ground& ground : grounds_of(frames_of(*drive, drive->size()), drive->rig())) {
    EXPECT_TRUE(ground.estimated);
    EXPECT_LT(ground.pitch_sigma_rad / degree, 0.3);
    EXPECT_LT(ground.height_sigma_m, 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Kitti, GroundDrives, testing::Values("kitti_odo04", "kitti_raw0009", "kitti_raw0001"),
                         [](const auto& drive) { return std::string{drive.param}; });

}  // namespace
}  // namespace stereogrid::test
