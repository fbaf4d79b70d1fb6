// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <set>

#include "stereogrid/io/image_file.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Expects a picture of some size with more than a few colours.
void expect_drawn(const fs::path& file) {
  const io::RgbImage image{io::read_rgb(file)};
  EXPECT_GT(image.width, 400) << file;
  EXPECT_GT(image.height, 300) << file;
  const std::set<std::uint8_t> shades(image.pixels.begin(), image.pixels.end());
  EXPECT_GT(shades.size(), 20U) << file;
}

/// A drive as KITTI's odometry has it, with a lidar sweep for one frame: two returns, 5 m ahead.
void make_drive_with_sweep(const fs::path& drive, const std::string& frame) {
  run_well({"simulate", small_scene("street", "&frames=5"), "--out", (drive / "plain").string(), "--no-truth"});
  fs::rename(drive / "plain" / "left", drive / "image_0");
  fs::rename(drive / "plain" / "right", drive / "image_1");
  fs::remove_all(drive / "plain");
  std::ofstream{drive / "calib.txt"} << "P0: 128.125 0 80 0 0 128.125 50 0 0 0 1 0\n"
                                     << "P1: 128.125 0 80 -28.1875 0 128.125 50 0 0 0 1 0\n"
                                     << "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n";
  fs::create_directory(drive / "velodyne");
  const std::vector<float> points{5, 0, -1, 0, 5, 1, -1.2F, 0};
  std::ofstream{drive / "velodyne" / (frame + ".bin"), std::ios::binary}.write(
      reinterpret_cast<const char*>(points.data()), static_cast<std::streamsize>(points.size() * sizeof(float)));
}

TEST(Figures, OfASceneAreDrawn) {
  const TemporaryFolder folder;
  const fs::path out{folder / "figures"};
  const Outcome outcome{run_well({"figures", small_scene("street", "&frames=5"), "--out", out.string()})};
  EXPECT_THAT(files_in(out), ElementsAre("figure_1.png", "figure_2.png", "figure_3.png", "figure_4.png", "figure_6.png",
                                         "figure_7.png", "figure_8.png"));
  for (const std::string& name : files_in(out)) expect_drawn(out / name);
  EXPECT_THAT(outcome.output, HasSubstr("frame 000002, in"));
  EXPECT_THAT(outcome.output, HasSubstr("Figure 9 is left out: frame 000002 has no lidar sweep."));
}

TEST(Figures, NeedNoInput) {
  const TemporaryFolder folder;
  const Outcome outcome{run_well({"figures", "--out", folder.path().string(), "--frame", "000000"})};
  EXPECT_THAT(outcome.output, HasSubstr("scene:street"));
  EXPECT_THAT(files_in(folder.path()), Not(ElementsAre()));
}

TEST(Figures, FollowTheSettings) {
  const TemporaryFolder folder;
  const std::string scene{small_scene("street", "&frames=1")};
  run_well({"figures", scene, "--out", (folder / "paper").string()});
  run_well({"figures", scene, "--out", (folder / "other").string(), "--set", "u_disparity.false_positive=0.2"});
  const auto same = [&](const std::string& name) {
    return text_of(folder / "paper" / name) == text_of(folder / "other" / name);
  };
  EXPECT_FALSE(same("figure_1.png"));
  EXPECT_FALSE(same("figure_3.png"));
  EXPECT_TRUE(same("figure_8.png")) << "sets both rates itself";
}

TEST(Figures, TheMiddleFrameWithALidarSweepIsTaken) {
  const TemporaryFolder folder;
  make_drive_with_sweep(folder / "drive", "000003");
  const fs::path out{folder / "figures"};
  const std::vector<std::string> words{"figures", (folder / "drive").string(), "--out", out.string()};
  EXPECT_THAT(run_well(words).output, HasSubstr("figures of drive, frame 000003"));
  expect_drawn(out / "figure_9.png");
  std::vector<std::string> other(words);
  other.insert(other.end(), {"--frame", "000001"});
  EXPECT_THAT(run_well(other).output, HasSubstr("frame 000001 has no lidar sweep"));
}

TEST(Figures, ADamagedFrameBeforeIsSkippedAndTheFrameItselfIsNot) {
  const TemporaryFolder folder;
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", (folder / "drive").string(), "--no-truth"});
  fs::resize_file(folder / "drive" / "left" / "000000.png", 100);
  const std::vector<std::string> words{"figures", (folder / "drive").string(), "--out", (folder / "out").string()};
  EXPECT_THAT(run_well(words).errors, HasSubstr("frame 000000 is skipped"));
  std::vector<std::string> damaged(words);
  damaged.insert(damaged.end(), {"--frame", "000000"});
  const Outcome outcome{run_tool(damaged)};
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_THAT(outcome.errors, HasSubstr("000000.png"));
}

TEST(Figures, ComplainOfAnUnknownFrame) {
  const TemporaryFolder folder;
  const Outcome outcome{
      run_tool({"figures", small_scene("street", "&frames=3"), "--out", (folder / "out").string(), "--frame", "7"})};
  EXPECT_EQ(outcome.exit_code, 64);
  EXPECT_THAT(outcome.errors,
              HasSubstr("--frame 7: the input has no frame of this name. It has 3 frames, 000000 to 000002."));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(Figures, ComplainOfNoSuchInput) {
  const TemporaryFolder folder;
  const Outcome outcome{run_tool({"figures", (folder / "nothing").string(), "--out", (folder / "out").string()})};
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_THAT(outcome.errors, HasSubstr("nothing"));
}

TEST(Figures, ComplainWhereNothingCanBeWritten) {
  const TemporaryFolder folder;
  std::ofstream{folder / "file"} << "not a folder";
  const Outcome outcome{
      run_tool({"figures", small_scene("street", "&frames=1"), "--out", (folder / "file" / "out").string()})};
  EXPECT_EQ(outcome.exit_code, 75);
  EXPECT_THAT(outcome.errors, HasSubstr("file"));
}

TEST(Figures, ComplainWithoutAFolder) {
  const Outcome outcome{run_tool({"figures"})};
  EXPECT_EQ(outcome.exit_code, 64);
  EXPECT_THAT(outcome.errors, HasSubstr("--out"));
}

}  // namespace
}  // namespace stereogrid::app::testing
