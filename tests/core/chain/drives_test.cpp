// SPDX-License-Identifier: Apache-2.0
//
// Real drives: the ground, what no frame has observed, and drops.
#include "ground_drive.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* no_data{"no data sets on this machine (STEREOGRID_DATA)"};

/// None: this machine does not have it.
std::unique_ptr<io::Recording> opened(const char* name) {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  const std::filesystem::path folder{
      (named ? std::filesystem::path{named} : std::filesystem::path{STEREOGRID_SOURCE_DIR} / "../shared/data") / name};
  if (!std::filesystem::exists(folder)) return nullptr;
  io::InputArguments arguments;
  arguments.paths = {folder};
  return io::open_recording(arguments);
}

class GroundDrives : public testing::TestWithParam<const char*> {};

// A calibration that is wrong, against the same drive with the right one.
TEST_P(GroundDrives, RecoversWithinFiveFrames) {
  const auto drive{opened(GetParam())};
  if (!drive) GTEST_SKIP() << no_data;
  const std::vector<StereoFrame> frames{frames_of(*drive, 8)};
  const std::vector<Ground> right{grounds_of(frames, drive->rig())};
  for (const WrongBy& by : {WrongBy{1, 0, 0}, WrongBy{-1, 0, 0}, WrongBy{0, 1, 0}, WrongBy{0, 0, 0.1}}) {
    SCOPED_TRACE(testing::Message() << by.pitch_deg << "° " << by.roll_deg << "° " << by.height_m << " m");
    expect_recovered(right, grounds_of(frames, wrong(drive->rig(), by)));
  }
}

TEST_P(GroundDrives, TheGateDoesNotBite) {
  const auto drive{opened(GetParam())};
  if (!drive) GTEST_SKIP() << no_data;
  for (const Ground& ground : grounds_of(frames_of(*drive, drive->size()), drive->rig())) {
    EXPECT_TRUE(ground.estimated);
    EXPECT_LT(ground.pitch_sigma_rad / degree, 0.3);
    EXPECT_LT(ground.height_sigma_m, 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Kitti, GroundDrives, testing::Values("kitti_odo04", "kitti_raw0009", "kitti_raw0001"),
                         [](const auto& drive) { return std::string{drive.param}; });

class NeverObservedOfDrives : public testing::TestWithParam<const char*> {};

// Ground that no frame has observed is unknown to the filter, too.
TEST_P(NeverObservedOfDrives, IsUnknownOrMoves) {
  const auto drive{opened(GetParam())};
  if (!drive) GTEST_SKIP() << no_data;
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

// Mean of 5 × 5 pixels: a blur of 1.4 px.
Image<std::uint8_t> blurred(const Image<std::uint8_t>& sharp) {
  constexpr int reach{2};
  Image<std::uint8_t> soft{sharp};
  for (const auto [u, v] : raster(reach, sharp.width() - reach, reach, sharp.height() - reach)) {
    int sum{0};
    for (int dv{-reach}; dv <= reach; ++dv) {
      for (int du{-reach}; du <= reach; ++du) sum += sharp(u + du, v + dv);
    }
    soft(u, v) = static_cast<std::uint8_t>(sum / 25);
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

// None has a drop, blurred images included.
TEST(DropsOfDrives, AreInOneFrameInAHundredAtMost) {
  Frames frames;
  for (const char* const name : {"kitti_odo04", "kitti_raw0009", "kitti_raw0001", "kitti_adas21"}) {
    const auto drive{opened(name)};
    if (!drive) GTEST_SKIP() << no_data;
    for (const bool is_soft : {false, true}) process(*drive, is_soft, frames);
  }
  EXPECT_LE(100 * frames.with_drops, frames.all);
}

}  // namespace
}  // namespace stereogrid::test
