// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Evaluate = FolderTest;

/// A run of a scene that is small enough for tests.
void run_scene(const std::string& scene, const fs::path& out) {
  run_well({"run", scene, "--out", out, "--set", "grid.length_m=30"});
}

TEST_F(Evaluate, ScoresARunAgainstItsScene) {
  run_scene("scene:crossing?frames=13&width=256&height=160", folder / "run");
  const std::string json_file{folder / "scores.json"};
  const Outcome outcome{run_well({"evaluate", folder / "run", "--json", json_file})};
  EXPECT_THAT(outcome.output, HasSubstr("log-loss"));
  EXPECT_THAT(outcome.output, HasSubstr("motion"));
  const Json scores(json_of(json_file));
  EXPECT_EQ(scores["about"]["frames"], "13 of 13");
  EXPECT_EQ(scores["about"]["truth"], "exact");
  EXPECT_FALSE(scores["series"]["observed"]["bands"].contains("3-20 clear")) << "exact truth labels no hidden ground";
  const Json band(scores["series"]["observed"]["bands"]["3-20"]);
  EXPECT_GT(band["cells"], 10000);
  EXPECT_GT(band["occupied"], 100);
  EXPECT_GT(band["hidden_occupied"], 10);
  EXPECT_GT(band["auc"]["value"], 0.7);
  EXPECT_LT(band["auc"]["value"], 1.0);
  EXPECT_LE(band["auc"]["low"], band["auc"]["value"]);
  EXPECT_GE(band["auc"]["high"], band["auc"]["value"]);
  EXPECT_GT(scores["series"]["occupancy"]["motion"]["sightings"], 0);
  EXPECT_FALSE(scores["series"]["observed"].contains("motion"));
  for (const char* series : {"observed", "occupancy"}) {
    const Json witness(scores["series"][series]["witness"]);
    EXPECT_EQ(witness["frames"], 13) << series;
    EXPECT_GT(witness["ground"], 1000) << series;
    EXPECT_LT(witness["ground_occupied"], 0.02 * witness["ground"].get<double>()) << series;
  }
  EXPECT_THAT(outcome.output, HasSubstr("frames with such a cell"));
  EXPECT_EQ(scores["about"]["obstacles"], "exact truth, 3 frames");
  EXPECT_THAT(outcome.output, HasSubstr("MOTA"));
  const Json obstacles(scores["obstacles"]);
  EXPECT_EQ(obstacles["frames"], 3);
  EXPECT_GT(obstacles["things"], 3);
  EXPECT_EQ(obstacles["things"], obstacles["tracking"]["objects"]);
  EXPECT_LE(obstacles["separate"], obstacles["found"]);
  EXPECT_GT(obstacles["free_cells"], 1000);
  EXPECT_TRUE(obstacles["tracking"]["mota"].is_number());
}

TEST_F(Evaluate, ScoresTerrainOfASceneAndOfItsDriveAlike) {
  const std::string scene{"scene:terrain?kind=box&width=256&height=160&frames=2"};
  const std::string run{folder / "run"};
  run_scene(scene, folder / "run");
  run_well({"simulate", scene, "--out", folder / "drive"});
  const auto scores = [&](const Words& input) {
    EXPECT_THAT(run_well(joined({"evaluate", run, "--json", folder / "scores.json"}, input)).output,
                HasSubstr("terrain (2 frames)"));
    return json_of(folder / "scores.json")["series"];
  };
  const Json own(scores({}));
  const Json near(own["observed"]["terrain"]["ranges"]["0-8"]);
  EXPECT_EQ(near["objects"], 2);
  EXPECT_EQ(near["objects_found"], 1);
  EXPECT_GT(near["drivable_free"], 0.88);  // in the first frames, ground nearer than the image shows is unknown
  EXPECT_LT(near["drivable_occupied"], 0.02);
  EXPECT_TRUE(near["edges_found"].is_null());
  EXPECT_EQ(scores({folder / "drive"})["occupancy"]["terrain"], own["occupancy"]["terrain"]);
}

// Shares of things that are an obstacle of their own, a little below those of the day of writing: no later change loses
// obstacles unseen. The drives were used for tuning.
TEST_F(Evaluate, SeparatesTheObstaclesOfDrives) {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  const fs::path data{named ? fs::path{named} : fs::path{STEREOGRID_SOURCE_DIR} / "../shared/data"};
  if (!fs::exists(data)) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  const std::vector<std::pair<const char*, double>> drives{{"synthetic/B-crossing", 0.75},
                                                           {"synthetic/C-street", 0.85},
                                                           {"synthetic/D-pitched", 0.88},
                                                           {"synthetic/E-kitti-like", 0.85},
                                                           {"kitti_raw0009", 0.92}};
  for (const auto& [drive, least] : drives) {
    const fs::path run{folder / "run" / drive};
    run_well({"run", data / drive, "--out", run});
    run_well({"evaluate", run, data / drive, "--json", folder / "scores.json"});
    const Json obstacles(json_of(folder / "scores.json")["obstacles"]);
    EXPECT_GT(obstacles["separate"], least) << drive;
    EXPECT_LT(obstacles["free_covered"], 0.02) << drive;
    EXPECT_LE(obstacles["moving_wrong"].is_null() ? 0 : obstacles["moving_wrong"].get<double>(), 0.03) << drive;
  }
}

TEST_F(Evaluate, ReadsTheTruthOfADriveAsThatOfItsScene) {
  const std::string scene{small_scene("street", "&frames=2")};
  const fs::path drive{folder / "drive"};
  run_well({"simulate", scene, "--out", drive});
  run_scene(scene, folder / "run");
  const std::string run{folder / "run"};
  const auto band = [&](const Words& input) {
    const std::string file{folder / "scores.json"};
    run_well(joined({"evaluate", run, "--json", file}, input));
    return json_of(file)["series"]["occupancy"]["bands"]["3-20"];
  };
  const Json by_scene(band({}));
  for (const Json& other : {band({scene, "--truth", "truth"}), band({drive})}) {
    for (const char* key : {"cells", "occupied", "auc", "balanced_log_loss", "iou_free", "depth_error_m"}) {
      EXPECT_EQ(other[key], by_scene[key]) << key;
    }
    // the files' disparities are rounded to 1/256 px, and cells a hair from the margin change sides
    EXPECT_NEAR(other["hidden_occupied"], by_scene["hidden_occupied"], 3);
  }
}

TEST_F(Evaluate, WritesAReportThatNeedsNothingElse) {
  // a path that would end the page's data, or not let it end
  const fs::path run{folder / "<!--<script>a<" / "script>"};
  run_scene(small_scene("crossing", "&frames=2"), run);
  const fs::path report{folder / "report.html"};
  run_well({"evaluate", run, "--html", report});
  const std::string page{text_of(report)};
  for (const char* part : {"<!doctype html>", "hidden_recall", "000001", "prefers-color-scheme", "function rocChart"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  for (const char* part :
       {"http", "src=", "href=", "@DATA@", "@THEME@", "@SCRIPT@", "import ", "a</script>", "<!--<script>"}) {
    EXPECT_THAT(page, Not(HasSubstr(part)));
  }
  const std::string begin{"type=\"application/json\">"};
  const std::size_t at{page.find(begin) + begin.size()};
  const Json data(Json::parse(page.substr(at, page.find("</script>", at) - at)));
  EXPECT_EQ(data["about"]["run"], run.string());
  EXPECT_EQ(data["series"]["observed"]["frames"]["3-20"].size(), 2U);
  if (!has_node()) GTEST_SKIP() << "node is not here: the report's script was not run";
  EXPECT_TRUE(script_fills(report));
}

TEST_F(Evaluate, ScoresObstaclesWhereOnlyTheyAreLabelled) {
  const fs::path drive{folder / "drive"};
  const fs::path run{folder / "run"};
  run_well({"simulate", small_scene("empty", "&frames=2"), "--out", drive});
  run_scene(drive.string(), run);
  fs::remove_all(drive / "truth");
  const auto label = [&](const std::string& name) {
    std::ofstream{drive / "objects.jsonl"}
        << R"({"name": ")" + name + R"(", "objects": [{"id": 1, "kind": "car",)" +
               R"( "x_m": 9, "y_m": 0, "yaw_rad": 0, "length_m": 4, "width_m": 2}]})";
  };
  label("000001");
  // an obstacle where the label is, before a wall
  std::vector<Json> lines(lines_of(run));
  Json car{{"id", 4},      {"x_m", 9.5},   {"y_m", 0},   {"vx_mps", 0},    {"vy_mps", 0},      {"length_m", 4},
           {"width_m", 2}, {"yaw_rad", 0}, {"age_s", 1}, {"occupancy", 1}, {"confirmed", true}};
  Json wall(car);
  wall["id"] = 5;
  wall["kind"] = "boundary";
  wall["outline_m"] = Json::array({{7, -2}, {7, 2}});
  lines[1]["obstacles"] = {car, wall};
  std::ofstream{run / "frames.jsonl"} << lines[0].dump() + "\n" + lines[1].dump() + "\n";
  const std::string file{folder / "scores.json"};
  const fs::path report{folder / "report.html"};
  run_well({"evaluate", run, "--json", file, "--html", report});
  const Json scores(json_of(file));
  EXPECT_EQ(scores["about"]["obstacles"], "labelled boxes, 1 frames");
  EXPECT_TRUE(scores["series"].empty());
  EXPECT_EQ(scores["obstacles"]["separate"], 1);
  EXPECT_EQ(scores["obstacles"]["errors"]["centre_m"], 0.5);
  EXPECT_TRUE(scores["obstacles"]["free_covered"].is_null());
  EXPECT_TRUE(scores["obstacles"]["tracking"]["mota"].is_null());
  EXPECT_EQ(scores["obstacles"]["tracking"]["idr"], 1);
  if (has_node()) {
    EXPECT_TRUE(script_fills(report));
  }

  label("000007");
  EXPECT_THAT(errors_of(65, {"evaluate", run}), HasSubstr("has object labels from 1 s on"));
}

TEST_F(Evaluate, RefusesCellsOfAnotherSize) {
  const std::string scene{small_scene("empty", "&frames=1")};
  run_well({"run", scene, "--out", folder / "run", "--set", "grid.cell_size_m=0.5"});
  EXPECT_THAT(errors_of(65, {"evaluate", folder / "run", scene}), HasSubstr("grid.cell_size_m=0.2"));
}

TEST_F(Evaluate, SaysWhatIsMissing) {
  const std::string scene{small_scene("empty", "&frames=2")};
  const fs::path drive{folder / "drive"};
  run_well({"simulate", scene, "--out", drive});
  run_scene(drive.string(), folder / "run");
  const auto error_text = [&](const Words& words) {
    return errors_of(65, joined({"evaluate", folder / "run"}, words));
  };
  EXPECT_THAT(error_text({"--truth", "lidar"}), HasSubstr("has no lidar sweeps. It has exact truth"));
  EXPECT_THAT(error_text({"scene:empty?frames=2&width=200&height=100"}),
              HasSubstr("images of 160 × 100 px, but the input's have 200 × 100 px"));
  EXPECT_THAT(error_text({scene, "--truth", "lidar"}), HasSubstr("input has no lidar"));

  // the same frames under other names
  const fs::path other{folder / "other"};
  run_well({"simulate", scene, "--out", other});
  edit(other / "truth" / "objects.jsonl", "\"00000", "\"10000");
  EXPECT_THAT(error_text({other}), HasSubstr("none of its frames (000000 to 000001) has ground truth"));

  fs::remove_all(drive / "truth");
  EXPECT_THAT(error_text({}), HasSubstr("has no lidar sweeps"));
  EXPECT_THAT(error_text({"--truth", "truth"}), HasSubstr("has no folder truth/"));
  fs::remove_all(drive);
  EXPECT_THAT(error_text({}), HasSubstr("is not there any more"));
  fs::remove_all(folder / "run" / "grids");
  EXPECT_THAT(error_text({}), HasSubstr("the run has no grids"));
  fs::remove_all(folder / "run");
  EXPECT_THAT(error_text({}), HasSubstr("is not a folder"));
}

}  // namespace
}  // namespace stereogrid::app::testing
