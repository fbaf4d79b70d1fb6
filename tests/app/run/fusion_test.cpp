// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "lidar_drive.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Fusion : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    put_lidar_drive(*folder_ / "drive");
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string drive() { return (*folder_ / "drive").string(); }

  static TemporaryFolder* folder_;
};

TemporaryFolder* Fusion::folder_{nullptr};

float largest_ahead(const fs::path& run, const std::string& name) {
  const Arrays grids{io::read_npz(run / "grids" / (name + ".npz"))};
  const auto cells{grids.at("observed").to_image<float>()};
  const float* const row{cells.row(cells.height() / 2)};
  return *std::max_element(row + 35, row + 45);  // 7 to 9 m ahead, cells of 0.2 m
}

TEST_F(Fusion, PutsTheLidarsObstaclesIntoTheGrid) {
  const TemporaryFolder folder;
  const fs::path alone{folder / "alone"};
  const fs::path both{folder / "both"};
  const std::string flat{"ground.model=plane"};
  run_well({"run", drive(), "--out", alone.string(), "--set", flat});
  const Outcome outcome{run_well({"run", drive(), "--out", both.string(), "--fuse", "lidar", "--set", flat})};
  // the images say surely that there is no wall
  EXPECT_LT(largest_ahead(alone, "000000"), 0.1F);
  EXPECT_GT(largest_ahead(both, "000000"), 0.85F);
  EXPECT_THAT(outcome.output, HasSubstr("1 of 3 frames had no lidar"));
  EXPECT_EQ(json_of(both / "run.json")["fuse"], (Json{{"source", "lidar"}}));
  EXPECT_EQ(json_of(alone / "run.json")["fuse"], (Json{{"source", "none"}}));
  EXPECT_THAT(lines_of(both)[0]["warnings"].dump(), Not(HasSubstr("stereo alone")));
  EXPECT_THAT(lines_of(both)[1]["warnings"].dump(), HasSubstr("stereo alone: no lidar sweep"));
  EXPECT_EQ(largest_ahead(alone, "000001"), largest_ahead(both, "000001")) << "a frame without a sweep";
}

TEST_F(Fusion, GoesOnWithoutASweepThatIsDamaged) {
  const TemporaryFolder folder;
  const fs::path copy{folder / "drive"};
  fs::copy(drive(), copy, fs::copy_options::recursive);
  std::ofstream{copy / "velodyne" / "000000.bin"} << "abc";
  const Outcome outcome{run_well({"run", copy.string(), "--out", (folder / "run").string(), "--fuse", "lidar"})};
  EXPECT_THAT(outcome.output, HasSubstr("2 of 3 frames had no lidar"));
  EXPECT_THAT(outcome.errors, HasSubstr("000000.bin"));
}

TEST_F(Fusion, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const auto error_text = [&](const std::string& input, const std::vector<std::string>& more, int exit_code) {
    std::vector<std::string> words{"run", input, "--out", (folder / "run").string()};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome{run_tool(words)};
    EXPECT_EQ(outcome.exit_code, exit_code);
    EXPECT_FALSE(fs::exists(folder / "run"));
    return outcome.errors;
  };
  const std::string scene{small_scene("empty", "&frames=2")};
  EXPECT_THAT(error_text(scene, {"--fuse", "lidar"}, 65), HasSubstr("scene has no lidar sweeps. Leave --fuse out"));
  EXPECT_THAT(error_text(scene, {"--fuse", "radar"}, 64), HasSubstr("radar"));
  const fs::path copy{folder / "drive"};
  fs::copy(drive(), copy, fs::copy_options::recursive);
  std::ofstream{copy / "calib.txt"} << "P0: 80 0 80 0 0 80 50 0 0 0 1 0\nP1: 80 0 80 -40 0 80 50 0 0 0 1 0\n";
  EXPECT_THAT(error_text(copy.string(), {"--fuse", "lidar"}, 65), HasSubstr("does not say where the lidar is"));
  fs::remove_all(copy / "velodyne");
  EXPECT_THAT(error_text(copy.string(), {"--fuse", "lidar"}, 65), HasSubstr("has no lidar sweeps. Put KITTI's folder"));
}

}  // namespace
}  // namespace stereogrid::app::testing
