// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

const char* const scene{"scene:street?width=256&height=160&frames=5"};

struct Poses : FolderTest {
  Poses() {
    run_well({"simulate", scene, "--out", drive_, "--no-truth"});
    run_well({"run", drive_, "--out", out("file")});
  }

  [[nodiscard]] std::string out(const std::string& name) const { return (folder / name).string(); }
  void remove_poses() const { fs::remove(folder / "drive" / "poses.csv"); }
  /// x of the last frame.
  [[nodiscard]] double x_m(const std::string& run) const {
    return lines_of(folder / run).back().at("pose").at("x_m").get<double>();
  }
  [[nodiscard]] std::string source(const std::string& run) const {
    return json_of(folder / run / "run.json").at("input").at("poses").get<std::string>();
  }
  const std::string drive_{folder / "drive"};
};

TEST_F(Poses, ABareDriveIsFollowedByOdometry) {
  remove_poses();
  const Outcome outcome{run_well({"run", drive_, "--out", out("bare")})};
  EXPECT_THAT(outcome.errors, HasSubstr("poses: none, visual odometry from the images"));
  EXPECT_EQ(source("bare"), "odometry");
  EXPECT_GT(x_m("file"), 2);
  EXPECT_NEAR(x_m("bare"), x_m("file"), 0.02 * x_m("file"));
  for (const Json& line : lines_of(folder / "bare")) {
    EXPECT_THAT(line["warnings"], IsEmpty());
    EXPECT_GT(line["timing_ms"]["odometry"], 0);
  }
  EXPECT_THAT(run_well({"info", drive_}).output, HasSubstr("none: visual odometry from the images"));
}

TEST_F(Poses, OdometryWhereThereIsAFile) {
  const Outcome outcome{run_well({"run", drive_, "--out", out("asked"), "--poses", "odometry"})};
  EXPECT_THAT(outcome.errors, HasSubstr("poses: visual odometry from the images"));
  EXPECT_EQ(source("asked"), "odometry");
  EXPECT_NE(x_m("asked"), x_m("file"));
  EXPECT_NEAR(x_m("asked"), x_m("file"), 0.02 * x_m("file"));
  run_well({"run", scene, "--out", out("scene"), "--poses", "odometry"});
  EXPECT_EQ(x_m("scene"), x_m("asked"));
}

TEST_F(Poses, NoneIsStandstill) {
  for (const std::string& input : {drive_, std::string{scene}}) {
    const std::string name{input == scene ? "scene" : "drive_none"};
    run_well({"run", input, "--out", out(name), "--poses", "none"});
    EXPECT_EQ(x_m(name), 0);
    EXPECT_THAT(lines_of(folder / name).front()["warnings"].dump(), HasSubstr("assumed to be static"));
  }
}

TEST_F(Poses, ARangeKeepsTheWorldOfTheDrive) {
  const auto expect_same_poses = [&](const std::string& input, const std::string& whole, const char* warm_up) {
    fs::remove_all(folder / "range");
    run_well({"run", input, "--out", out("range"), "--frames", "3:", "--warm-up", warm_up});
    const std::vector<Json> all(lines_of(folder / whole));
    const std::vector<Json> range(lines_of(folder / "range"));
    ASSERT_EQ(range.size(), 2U);
    for (std::size_t i{0}; i < range.size(); ++i) {
      for (const char* key : {"x_m", "y_m", "yaw_rad"}) {
        EXPECT_NEAR(range[i]["pose"][key].get<double>(), all[3 + i]["pose"][key].get<double>(), 1e-9);
      }
    }
  };
  run_well({"run", scene, "--out", out("scene")});
  expect_same_poses(drive_, "file", "0");
  expect_same_poses(drive_, "file", "2");
  expect_same_poses(scene, "scene", "1");
}

TEST_F(Poses, FileMeansTheInputsOwn) {
  run_well({"run", drive_, "--out", out("again"), "--poses", "file"});
  EXPECT_EQ(x_m("again"), x_m("file"));
  remove_poses();
  EXPECT_THAT(errors_of(65, {"run", drive_, "--out", out("without"), "--poses", "file"}),
              AllOf(HasSubstr("there are no poses"), HasSubstr("--poses odometry")));
}

TEST_F(Poses, AFileThatIsNotThereIsNamed) {
  EXPECT_THAT(errors_of(65, {"run", drive_, "--out", out("x"), "--poses", out("nowhere.csv")}),
              HasSubstr("nowhere.csv"));
  EXPECT_EQ(run_tool({"run", scene, "--out", out("y"), "--poses", out("nowhere.csv")}).exit_code, 64);
}

TEST_F(Poses, DarkFramesAreCarriedOnWithAWarning) {
  remove_poses();
  for (const char* const side : {"left", "right"}) {
    fs::remove(folder / "drive" / side / "000003.png");
    std::ofstream{folder / "drive" / side / "000003.pgm"} << "P5\n256 160\n255\n" << std::string(256 * 160, '\x10');
  }
  run_well({"run", drive_, "--out", out("dark")});
  const std::vector<Json> lines(lines_of(folder / "dark"));
  EXPECT_THAT(lines[2]["warnings"].dump(), Not(HasSubstr("odometry")));
  EXPECT_THAT(lines[3]["warnings"].dump(), HasSubstr("odometry: too few points agree"));
  EXPECT_NEAR(x_m("dark"), x_m("file"), 0.1 * x_m("file"));
}

const char* const street{"scene:street?frames=4&width=256&height=160"};

struct Given : FolderTest {
  Given() { run_well({"simulate", street, "--out", drive()}); }
  [[nodiscard]] std::string drive() const { return (folder / "drive").string(); }
  [[nodiscard]] std::string truth() const { return (folder / "drive" / "truth" / "disparity").string(); }
  [[nodiscard]] std::string out(const char* name) const { return (folder / name).string(); }
  [[nodiscard]] Json run_json(const char* name) const { return json_of(folder / name / "run.json"); }
  [[nodiscard]] double log_loss_of(const char* name) const {
    run_well({"evaluate", out(name), drive(), "--json", out("scores.json")});
    return json_of(folder / "scores.json")["series"]["observed"]["bands"]["3-20"]["balanced_log_loss"]["value"];
  }
};

TEST_F(Given, ExactDisparitiesBeatOurMatcher) {
  run_well({"run", drive(), "--out", out("own")});
  run_well({"run", drive(), "--out", out("given"), "--disparities", truth()});
  EXPECT_LT(log_loss_of("given"), log_loss_of("own"));
  EXPECT_EQ(run_json("own")["matcher"], "own");
  EXPECT_EQ(run_json("given")["matcher"], "given");
  EXPECT_THAT(run_json("given")["input"]["disparities"].get<std::string>(), HasSubstr("truth/disparity"));
}

TEST_F(Given, AFolderWithoutRightImagesRunsByItself) {
  run_well({"run", drive(), "--out", out("named"), "--disparities", truth()});
  fs::rename(truth(), folder / "drive" / "disparity");
  fs::remove_all(folder / "drive" / "right");
  run_well({"run", drive(), "--out", out("found"), "--pictures", "--save-stages"});
  EXPECT_EQ(lines_of(folder / "found", false), lines_of(folder / "named", false));
  EXPECT_EQ(files_in(folder / "found" / "pictures").size(), 4U);
  const std::string said{run_well({"info", drive()}).output};
  EXPECT_THAT(said, HasSubstr("left images with external disparities"));
  EXPECT_THAT(said, HasSubstr("4 can be used"));
}

TEST_F(Given, AMissingOneIsASkippedFrame) {
  fs::remove(fs::path{truth()} / "000002.png");
  const Outcome outcome{run_well({"run", drive(), "--out", out("run"), "--disparities", truth()})};
  EXPECT_THAT(outcome.output, HasSubstr("3 frames, 1 of 4 skipped"));
  const Json run(run_json("run"));
  ASSERT_EQ(run["skipped"].size(), 1U);
  EXPECT_THAT(run["skipped"][0]["reason"].get<std::string>(),
              HasSubstr("the disparity image of this frame is missing"));
}

TEST_F(Given, WhatCannotBe) {
  const auto refused{[&](const Words& more, int exit_code, const char* said) {
    EXPECT_THAT(errors_of(exit_code, joined({"run", drive(), "--out", out("run")}, more)), HasSubstr(said));
    EXPECT_FALSE(fs::exists(folder / "run"));
  }};
  refused({"--matcher", "opencv-bm"}, 64, "--matcher");
  refused({"--disparities", out("nowhere")}, 65, "no such folder");
  refused({"--disparities", drive() + "/left"}, 65, "16 bits");
  const Outcome of_scene{run_tool({"run", street, "--out", out("run"), "--disparities", truth()})};
  EXPECT_EQ(of_scene.exit_code, 64);
}

}  // namespace
}  // namespace stereogrid::app::testing
