// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Config, PageIsUpToDate) {
  const fs::path page{fs::path{STEREOGRID_SOURCE_DIR} / "docs" / "config.md"};
  EXPECT_EQ(run_well({"config", "--markdown"}).output, text_of(page))
      << "make it anew: stereogrid config --markdown > docs/config.md";
}

TEST(Config, ShowsAPreset) {
  const Json json(Json::parse(run_well({"config", "--preset", "paper", "--json"}).output));
  EXPECT_EQ(json["filter"]["model"], "tay2008");
}

TEST(Config, TakesAFileAndThenSettings) {
  const TemporaryFolder folder;
  const std::string file{(folder / "mine.yaml").string()};
  std::ofstream{file} << "grid: {length_m: 35, width_m: 25}\n";
  const Json json(Json::parse(
      run_well({"config", "--json", "--config", file, "--set", "grid.width_m=15", "--set", "tracking.cells_min=5"})
          .output));
  EXPECT_EQ(json["grid"]["length_m"], 35.0);
  EXPECT_EQ(json["grid"]["width_m"], 15.0);
  EXPECT_EQ(json["tracking"]["cells_min"], 5);
}

TEST(Simulate, WritesADriveThatRunReadsLikeTheScene) {
  const TemporaryFolder folder;
  const std::string scene{small_scene("street", "&frames=3")};
  run_well({"simulate", scene, "--out", (folder / "drive").string()});
  EXPECT_THAT(files_in(folder / "drive"), ElementsAre("calibration.yaml", "left", "poses.csv", "right", "truth"));
  EXPECT_THAT(files_in(folder / "drive" / "left"), ElementsAre("000000.png", "000001.png", "000002.png"));
  run_well({"run", scene, "--out", (folder / "a").string()});
  run_well({"run", (folder / "drive").string(), "--out", (folder / "b").string()});
  // poses.csv has whole micrometres
  const std::vector<Json> a(lines_of(folder / "a"));
  const std::vector<Json> b(lines_of(folder / "b"));
  ASSERT_EQ(b.size(), 3U);
  for (std::size_t i{0}; i < 3; ++i) {
    for (const char* key : {"name", "stamp_ns", "ground", "density"}) EXPECT_EQ(a[i][key], b[i][key]) << key;
    EXPECT_NEAR(a[i]["pose"]["x_m"].get<double>(), b[i]["pose"]["x_m"].get<double>(), 1e-6);
    EXPECT_NEAR(a[i]["pose"]["yaw_rad"].get<double>(), b[i]["pose"]["yaw_rad"].get<double>(), 1e-6);
  }
}

TEST(Simulate, ObeysItsOptions) {
  const TemporaryFolder folder;
  run_well({"simulate", "empty", "--out", (folder / "drive").string(), "--frames", "2", "--seed", "7", "--width", "96",
            "--height", "64", "--no-truth"});
  EXPECT_THAT(files_in(folder / "drive"), ElementsAre("calibration.yaml", "left", "poses.csv", "right"));
  EXPECT_EQ(files_in(folder / "drive" / "right").size(), 2U);
}

TEST(Info, TellsWhatIsThere) {
  const TemporaryFolder folder;
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", (folder / "drive").string()});
  const std::string said{run_well({"info", (folder / "drive").string()}).output};
  for (const char* part : {"plain folder", "3, 000000 to 000002", "160 × 100 px", "calibration.yaml", "poses.csv",
                           "10 frames per second", "100 × 100 cells", "3 can be used", "fine"}) {
    EXPECT_THAT(said, HasSubstr(part));
  }
}

TEST(Info, ComplainsOfADamagedFrameAndStaysUsable) {
  const TemporaryFolder folder;
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", (folder / "drive").string()});
  fs::resize_file(folder / "drive" / "left" / "000001.png", 100);
  const std::string said{run_well({"info", (folder / "drive").string()}).output};
  EXPECT_THAT(said, HasSubstr("frame 000001 cannot be used"));
  EXPECT_THAT(said, HasSubstr("usable"));
}

TEST(Evaluate, ScoresARunAgainstItsScene) {
  const TemporaryFolder folder;
  const std::string scene{"scene:crossing?frames=13&width=256&height=160"};
  run_well({"run", scene, "--out", (folder / "run").string()});
  const std::string json_file{(folder / "scores.json").string()};
  const Outcome outcome{run_well({"evaluate", (folder / "run").string(), scene, "--json", json_file})};
  EXPECT_THAT(outcome.output, HasSubstr("balanced log-loss"));
  const Json scores(json_of(json_file));
  EXPECT_EQ(scores["frames"], 13);
  EXPECT_GT(scores["observed"]["cells"], 10000);
  EXPECT_GT(scores["observed"]["occupied"], 100);
  EXPECT_GT(scores["observed"]["auc"], 0.7);
  EXPECT_LT(scores["observed"]["auc"], 1.0);
  EXPECT_GT(scores["observed"]["accuracy"], 0.6);
  EXPECT_GT(scores["motion"]["sightings"], 0);
}

TEST(Evaluate, ReadsTheTruthOfADriveAsThatOfItsScene) {
  const TemporaryFolder folder;
  const std::string scene{small_scene("street", "&frames=2")};
  const fs::path drive{folder / "drive"};
  run_well({"simulate", scene, "--out", drive.string()});
  run_well({"run", scene, "--out", (folder / "run").string(), "--set", "grid.length_m=30"});
  const std::string run{(folder / "run").string()};
  const std::string by_scene{run_well({"evaluate", run, scene}).output};
  EXPECT_EQ(run_well({"evaluate", run, drive.string()}).output, by_scene);
  EXPECT_EQ(run_well({"evaluate", run, "--truth", (drive / "truth").string()}).output, by_scene);
}

TEST(Evaluate, RefusesCellsOfAnotherSize) {
  const TemporaryFolder folder;
  const std::string scene{small_scene("empty", "&frames=1")};
  run_well({"run", scene, "--out", (folder / "run").string(), "--set", "grid.cell_size_m=0.5"});
  const Outcome outcome{run_tool({"evaluate", (folder / "run").string(), scene})};
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_THAT(outcome.errors, HasSubstr("grid.cell_size_m=0.2"));
}

}  // namespace
}  // namespace stereogrid::app::testing
