// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int ring_count{64};
constexpr int beam_count{2000};

/// Rings from left to right over a road; every second one of the upper rings, the odd ones, meets a wall 8 m ahead.
std::vector<float> sweep() {
  std::vector<float> scan;
  for (int ring{0}; ring < ring_count; ++ring) {
    const bool is_road{ring < 40 || ring % 2 == 0};
    const double x{is_road ? 3 + 0.2 * (ring % 40) : 8};
    const double z{is_road ? -1.65 : -1.6 + 0.08 * (ring - 40)};
    for (int beam{0}; beam < beam_count; ++beam) {
      const double y{10.0 * (1 - 2.0 * beam / beam_count)};
      for (const double value : {x, y, z, 0.5}) scan.push_back(static_cast<float>(value));
    }
  }
  return scan;
}

/// A drive of three frames in KITTI's odometry form; the first and the last have a sweep.
void put_drive(const fs::path& drive) {
  run_well({"simulate", small_scene("empty", "&frames=3"), "--out", (drive / "plain").string()});
  fs::create_directories(drive / "velodyne");
  fs::rename(drive / "plain" / "left", drive / "image_0");
  fs::rename(drive / "plain" / "right", drive / "image_1");
  std::ofstream{drive / "calib.txt"} << "P0: 80 0 80 0 0 80 50 0 0 0 1 0\nP1: 80 0 80 -40 0 80 50 0 0 0 1 0\n"
                                        "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n";
  std::ofstream{drive / "times.txt"} << "0.0\n0.1\n0.2\n";
  const std::vector<float> scan{sweep()};
  for (const char* name : {"000000", "000002"}) {
    std::ofstream file{drive / "velodyne" / (std::string{name} + ".bin"), std::ios::binary};
    file.write(reinterpret_cast<const char*>(scan.data()), static_cast<std::streamsize>(scan.size() * sizeof(float)));
  }
}

class Fusion : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    put_drive(*folder_ / "drive");
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
  // the drive's camera is mounted lower than its calibration says
  const std::string trusting{"ground.estimate=false"};
  run_well({"run", drive(), "--out", alone.string(), "--set", trusting});
  const Outcome outcome{run_well({"run", drive(), "--out", both.string(), "--fuse", "lidar", "--set", trusting})};
  // the images say that there is no wall
  EXPECT_LT(largest_ahead(alone, "000000"), 0.45F);
  EXPECT_GT(largest_ahead(both, "000000"), 0.9F);
  EXPECT_THAT(outcome.output, HasSubstr("1 of 3 frames had no lidar"));
  EXPECT_EQ(json_of(both / "run.json")["fuse"], (Json{{"source", "lidar"}, {"rings", "all"}}));
  EXPECT_EQ(json_of(alone / "run.json")["fuse"], (Json{{"source", "none"}, {"rings", "all"}}));
  EXPECT_THAT(lines_of(both)[0]["warnings"].dump(), Not(HasSubstr("stereo alone")));
  EXPECT_THAT(lines_of(both)[1]["warnings"].dump(), HasSubstr("stereo alone: no lidar sweep"));
  EXPECT_EQ(largest_ahead(alone, "000001"), largest_ahead(both, "000001")) << "a frame without a sweep";
}

TEST_F(Fusion, TakesTheRingsAskedForAndScoresWithTheOthers) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& rings) {
    fs::path out{folder / rings};
    run_well({"run", drive(), "--out", out.string(), "--fuse", "lidar", "--fuse-rings", rings, "--set",
              "fusion.stereo_confidence=0"});
    EXPECT_EQ(json_of(out / "run.json")["fuse"]["rings"], rings);
    return out;
  };
  const auto occupied = [&](const fs::path& of, const std::string& rings) {
    const std::string file{(folder / "scores.json").string()};
    run_well({"evaluate", of.string(), "--rings", rings, "--json", file});
    const Json scores(json_of(file));
    EXPECT_EQ(scores["about"]["truth"], "lidar, " + rings + " rings");
    return scores["series"]["observed"]["bands"]["3-20"]["occupied"].get<int>();
  };
  const fs::path even{run("even")};
  EXPECT_LT(largest_ahead(even, "000000"), 0.5f) << "the wall is in the odd rings";
  EXPECT_GT(largest_ahead(run("odd"), "000000"), 0.9F);
  EXPECT_EQ(occupied(even, "even"), 0);
  EXPECT_GT(occupied(even, "odd"), 50);
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
  const auto complaint = [&](const std::string& input, const std::vector<std::string>& more, int exit_code) {
    std::vector<std::string> words{"run", input, "--out", (folder / "run").string()};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome{run_tool(words)};
    EXPECT_EQ(outcome.exit_code, exit_code);
    EXPECT_FALSE(fs::exists(folder / "run"));
    return outcome.errors;
  };
  const std::string scene{small_scene("empty", "&frames=2")};
  EXPECT_THAT(complaint(scene, {"--fuse", "lidar"}, 65), HasSubstr("scene has no lidar sweeps. Leave --fuse out"));
  EXPECT_THAT(complaint(scene, {"--fuse", "radar"}, 64), HasSubstr("radar"));
  EXPECT_THAT(complaint(drive(), {"--fuse-rings", "odd"}, 64), HasSubstr("Give --fuse lidar"));
  const fs::path copy{folder / "drive"};
  fs::copy(drive(), copy, fs::copy_options::recursive);
  std::ofstream{copy / "calib.txt"} << "P0: 80 0 80 0 0 80 50 0 0 0 1 0\nP1: 80 0 80 -40 0 80 50 0 0 0 1 0\n";
  EXPECT_THAT(complaint(copy.string(), {"--fuse", "lidar"}, 65), HasSubstr("does not say where the lidar is"));
  fs::remove_all(copy / "velodyne");
  EXPECT_THAT(complaint(copy.string(), {"--fuse", "lidar"}, 65), HasSubstr("has no lidar sweeps. Put KITTI's folder"));

  run_well({"run", scene, "--out", (folder / "run").string()});
  const Outcome outcome{run_tool({"evaluate", (folder / "run").string(), "--rings", "odd"})};
  EXPECT_EQ(outcome.exit_code, 64);
  EXPECT_THAT(outcome.errors, HasSubstr("--truth lidar"));
}

}  // namespace
}  // namespace stereogrid::app::testing
