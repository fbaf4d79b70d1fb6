// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

constexpr int ring_count{64};
constexpr int beam_count{2000};

/// Rings from left to right over a road; every second one of the upper rings, the odd ones, meets a wall 8 m ahead.
std::vector<float> ringed_sweep() {
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

/// Writes a drive over an empty road in KITTI's odometry form, without extrinsics, in which the images show no wall;
/// `scan` is the sweep of the frames `swept`, of a level lidar at the camera's place.
void put_drive(const fs::path& drive, int focal_px, double camera_height_m, double pitch_deg,
               const std::vector<float>& scan, const std::vector<bool>& swept) {
  std::ostringstream scene;
  scene << "scene:empty?width=" << 2 * focal_px << "&height=" << focal_px * 5 / 4 << "&frames=" << swept.size()
        << "&focal=" << focal_px << "&baseline=0.5&camera_height=" << camera_height_m << "&pitch_deg=" << pitch_deg;
  run_well({"simulate", scene.str(), "--out", drive / "plain"});
  fs::create_directories(drive / "velodyne");
  fs::rename(drive / "plain" / "left", drive / "image_0");
  fs::rename(drive / "plain" / "right", drive / "image_1");
  std::ofstream calibration{drive / "calib.txt"};
  for (const int camera : {0, 1}) {
    calibration << "P" << camera << ": " << focal_px << " 0 " << focal_px << " " << -camera * focal_px / 2 << " 0 "
                << focal_px << " " << focal_px * 5 / 8 << " 0 0 0 1 0\n";
  }
  // y = c·(−z) − s·x, z = s·(−z) + c·x of the pitched camera
  const double s{std::sin(pitch_deg / 57.29577951308232)};
  const double c{std::cos(pitch_deg / 57.29577951308232)};
  calibration << "Tr: 0 -1 0 0 " << -s << " 0 " << -c << " 0 " << c << " 0 " << -s << " 0\n";
  std::ofstream times{drive / "times.txt"};
  for (std::size_t i{0}; i < swept.size(); ++i) {
    times << 0.1 * static_cast<double>(i) << "\n";
    if (!swept[i]) continue;
    std::ofstream file{drive / "velodyne" / ("00000" + std::to_string(i) + ".bin"), std::ios::binary};
    file.write(reinterpret_cast<const char*>(scan.data()), static_cast<std::streamsize>(scan.size() * sizeof(float)));
  }
}

class Fusion : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    put_drive(drive(), 80, 1.65, 0, ringed_sweep(), {true, false, true});
  }
  static std::string drive() { return (*folder / "drive").string(); }
};

/// Maximum of the observed grid's row straight ahead, `from_m` to `to_m`.
float largest_ahead(const fs::path& run, const std::string& name, double from_m = 7, double to_m = 9) {
  const Arrays grids{io::read_npz(run / "grids" / (name + ".npz"))};
  const auto cells{grids.at("observed").to_image<float>()};
  const float* const row{cells.row(cells.height() / 2)};
  return *std::max_element(row + std::lround(from_m / 0.2), row + std::lround(to_m / 0.2));
}

TEST_F(Fusion, PutsTheLidarsObstaclesIntoTheGrid) {
  const TemporaryFolder folder;
  const fs::path alone{folder / "alone"};
  const fs::path both{folder / "both"};
  const std::string flat{"ground.model=plane"};
  run_well({"run", drive(), "--out", alone, "--set", flat});
  const Outcome outcome{run_well({"run", drive(), "--out", both, "--fuse", "lidar", "--set", flat})};
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

TEST_F(Fusion, LiveFusesTheSweepsOfARecording) {
  const TemporaryFolder folder;
  const std::string bag{folder / "live.mcap"};
  run_well({"run", drive(), "--out", folder / "run", "--fuse", "lidar"});
  const Outcome live{run_well(
      {"live", drive(), "--fuse", "lidar", "--mcap", bag, "--mcap-topics", "observed_grid", "--listen", ":0"})};
  const auto said = [&](const char* text) { return live.errors.find(text) != std::string::npos; };
  EXPECT_EQ(said("stereo alone: no lidar sweep"), said("; not fused: 1")) << "that frame may be dropped" << live.errors;
  const auto recorded{mcap::open_bag(bag)};
  const auto cursor{recorded->messages({})};
  const mcap::Message* const first{cursor->next()};
  ASSERT_NE(first, nullptr);
  messages::nav_msgs::OccupancyGrid grid;
  messages::decode(first->data, grid);
  const Arrays arrays{io::read_npz(folder / "run" / "grids" / "000000.npz")};
  const auto cells{arrays.at("observed").to_image<float>()};
  EXPECT_EQ(grid.data, occupancy_values(cells.view(), OccupancyScale::percent));
  const Outcome none{run_tool({"live", drive(), "--fuse", "labels", "--listen", ":0"})};
  EXPECT_EQ(none.exit_code, 65);
  EXPECT_THAT(none.errors, HasSubstr("has no labels. Put label images in labels/"));
  EXPECT_EQ(none.output, "") << "no page is opened for an input that cannot be used";
}

TEST_F(Fusion, GoesOnWithoutASweepThatIsDamaged) {
  const TemporaryFolder folder;
  const fs::path copy{folder / "drive"};
  fs::copy(drive(), copy, fs::copy_options::recursive);
  std::ofstream{copy / "velodyne" / "000000.bin"} << "abc";
  const Outcome outcome{run_well({"run", copy, "--out", folder / "run", "--fuse", "lidar"})};
  EXPECT_THAT(outcome.output, HasSubstr("2 of 3 frames had no lidar"));
  EXPECT_THAT(outcome.errors, HasSubstr("000000.bin"));
}

TEST_F(Fusion, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const auto error_text = [&](const std::string& input, const Words& more, int exit_code) {
    const std::string errors{errors_of(exit_code, joined({"run", input, "--out", folder / "run"}, more))};
    EXPECT_FALSE(fs::exists(folder / "run"));
    return errors;
  };
  const std::string scene{small_scene("empty", "&frames=2")};
  EXPECT_THAT(error_text(scene, {"--fuse", "lidar"}, 65), HasSubstr("input has no lidar sweeps. Leave --fuse out"));
  EXPECT_THAT(error_text(scene, {"--fuse", "radar"}, 64), HasSubstr("radar"));
  const fs::path copy{folder / "drive"};
  fs::copy(drive(), copy, fs::copy_options::recursive);
  std::ofstream{copy / "calib.txt"} << "P0: 80 0 80 0 0 80 50 0 0 0 1 0\nP1: 80 0 80 -40 0 80 50 0 0 0 1 0\n";
  EXPECT_THAT(error_text(copy.string(), {"--fuse", "lidar"}, 65), HasSubstr("does not say where the lidar is"));
  fs::remove_all(copy / "velodyne");
  EXPECT_THAT(error_text(copy.string(), {"--fuse", "lidar"}, 65), HasSubstr("has no lidar sweeps. Put KITTI's folder"));
}

constexpr double camera_height_m{1.2};

/// A road, and a wall of 4 m 8 m ahead, as (x, y, z).
std::vector<float> sweep() {
  std::vector<float> scan;
  const auto add = [&](double x, double y, double z) {
    for (const double value : {x, y, z, 0.5}) scan.push_back(static_cast<float>(value));
  };
  for (double x{4.02}; x < 8; x += 0.05) {
    for (double y{-6}; y < 6; y += 0.1) add(x, y, -camera_height_m);
  }
  for (double z{-camera_height_m}; z < 1; z += 0.1) {
    for (double y{-2}; y < 2; y += 0.05) add(8.1, y, z);
  }
  return scan;
}

/// Six frames, with the sweep in each.
void put_drive(const fs::path& drive, double pitch_deg) {
  put_drive(drive, 160, camera_height_m, pitch_deg, sweep(), std::vector<bool>(6, true));
}

class FoundExtrinsics : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    const std::string drive{*folder / "drive"};
    put_drive(drive, 8);
    run_well({"run", drive, "--out", alone(), "--poses", "none"});
    run_well({"run", drive, "--out", fused(), "--poses", "none", "--fuse", "lidar"});
  }
  static fs::path alone() { return *folder / "alone"; }
  static fs::path fused() { return *folder / "fused"; }
};

TEST_F(FoundExtrinsics, StandsInTheLinesOfTheFrames) {
  const std::vector<Json> lines = lines_of(alone());  // no braces: they would make a list of it
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0]["status"], Json{"pose_missing"}) << "the first pair determines them";
  EXPECT_NEAR(lines[0]["mount"]["camera_pitch_rad"].get<double>(), 8 / 57.29577951308232, 0.004);
  EXPECT_NEAR(lines[5]["mount"]["camera_height_m"].get<double>(), camera_height_m, 0.03);
  EXPECT_EQ(lines[5]["mount"], json_of(alone() / "run.json")["mount"]);
}

TEST_F(FoundExtrinsics, PlacesTheLidarThatIsFused) {
  EXPECT_LT(largest_ahead(alone(), "000004", 7.4, 9), 0.5f);
  EXPECT_GT(largest_ahead(fused(), "000004", 8, 8.4), 0.8f) << "the wall";
  EXPECT_LT(largest_ahead(fused(), "000004", 4.4, 7.6), 0.5f) << "the road before it";
}

// With the calibration's extrinsics the road's returns rise by 1 m and more, and next to no cell is labelled.
TEST_F(FoundExtrinsics, LabelsTheCells) {
  const auto band_of = [&](const fs::path& run, const Words& more) {
    const std::string file{run.parent_path() / "scores.json"};
    run_well(joined({"evaluate", run, "--json", file}, more));
    return json_of(file)["series"]["observed"]["bands"]["3-20"];
  };
  const Json found(band_of(alone(), {}));
  // per frame: the wall's 20 cells or 21 across, and the cells of the road between 4 and 8 m
  EXPECT_GE(found["occupied"].get<int>(), 6 * 20);
  EXPECT_LE(found["occupied"].get<int>(), 6 * 2 * 21);
  EXPECT_GT(found["cells"].get<int>() - found["occupied"].get<int>(), 6 * 20 * 35);
  const Json with_lidar(band_of(fused(), {}));
  EXPECT_EQ(with_lidar["cells"], found["cells"]);
  EXPECT_GT(with_lidar["auc"]["value"].get<double>(), found["auc"]["value"].get<double>());

  // the same returns before a level camera, whose calibration is right
  put_drive(*folder / "level", 0);
  const fs::path level{*folder / "level_run"};
  run_well({"run", *folder / "level", "--out", level, "--poses", "none"});
  const Json expected(band_of(level, {"--camera-height", "1.2"}));
  EXPECT_NEAR(found["occupied"].get<int>(), expected["occupied"].get<int>(), 0.1 * expected["occupied"].get<int>());
  EXPECT_NEAR(found["cells"].get<int>(), expected["cells"].get<int>(), 0.05 * expected["cells"].get<int>());
}

}  // namespace
}  // namespace stereogrid::app::testing
