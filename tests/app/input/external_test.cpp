// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Runs on disparities that others have made.
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;

const char* const scene{"scene:street?frames=4&width=256&height=160"};

class Given : public ::testing::Test {
 protected:
  Given() { run_well({"simulate", scene, "--out", drive()}); }
  [[nodiscard]] std::string drive() const { return (folder_ / "drive").string(); }
  [[nodiscard]] std::string truth() const { return (folder_ / "drive" / "truth" / "disparity").string(); }
  [[nodiscard]] std::string out(const char* name) const { return (folder_ / name).string(); }
  [[nodiscard]] Json run_json(const char* name) const { return json_of(folder_ / name / "run.json"); }
  [[nodiscard]] double log_loss_of(const char* name) const {
    run_well({"evaluate", out(name), drive(), "--json", out("scores.json")});
    return json_of(folder_ / "scores.json")["series"]["observed"]["bands"]["3-20"]["balanced_log_loss"]["value"];
  }

  TemporaryFolder folder_;
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
  fs::rename(truth(), folder_ / "drive" / "disparity");
  fs::remove_all(folder_ / "drive" / "right");
  run_well({"run", drive(), "--out", out("found"), "--pictures", "--save-stages"});
  EXPECT_EQ(lines_of(folder_ / "found", false), lines_of(folder_ / "named", false));
  EXPECT_EQ(files_in(folder_ / "found" / "pictures").size(), 4U);
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
  const auto refused{[&](const std::vector<std::string>& more, int exit_code, const char* said) {
    std::vector<std::string> words{"run", drive(), "--out", out("run")};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome{run_tool(words)};
    EXPECT_EQ(outcome.exit_code, exit_code) << said;
    EXPECT_THAT(outcome.errors, HasSubstr(said));
    EXPECT_FALSE(fs::exists(folder_ / "run"));
  }};
  refused({"--matcher", "opencv-bm"}, 64, "--matcher");
  refused({"--disparities", out("nowhere")}, 65, "no such folder");
  refused({"--disparities", drive() + "/left"}, 65, "16 bits");
  const Outcome of_scene{run_tool({"run", scene, "--out", out("run"), "--disparities", truth()})};
  EXPECT_EQ(of_scene.exit_code, 64);
}

}  // namespace
}  // namespace stereogrid::app::testing
