// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "stereogrid/config.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

/// Four frames of a street, compared once for all tests.
class Compare : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    outcome_ = new Outcome{run_well({"compare", scene(), "--json", (*folder_ / "scores.json").string(), "--pictures",
                                     (*folder_ / "pictures").string()})};
  }
  static void TearDownTestSuite() {
    delete outcome_;
    delete folder_;
  }

  static std::string scene() { return "scene:street?frames=4&width=256&height=160"; }
  static Json methods() { return json_of(*folder_ / "scores.json")["methods"]; }
  static Json method(const std::string& name) {
    for (const Json& method : methods()) {
      if (method["name"] == name) return method;
    }
    ADD_FAILURE() << "no method " << name;
    return {};
  }
  static double score(const Json& method, const std::string& figure) {
    return method["scores"]["3-20 m"][figure]["value"].get<double>();
  }

  static TemporaryFolder* folder_;
  static Outcome* outcome_;
};

TemporaryFolder* Compare::folder_{nullptr};
Outcome* Compare::outcome_{nullptr};

TEST_F(Compare, RunsEveryMethodAndFilterModel) {
  std::vector<std::string> names;
  for (const Json& method : methods()) names.push_back(method["name"]);
  for (const char* name : {"observed", "observed_paper", "nearest_obstacle", "occupancy_boundary", "free_space",
                           "stixels", "ray_casting", "ray_casting_map"}) {
    EXPECT_THAT(names, Contains(name));
  }
  for (const std::string_view model : names_of(FilterModel{})) {
    EXPECT_THAT(names, Contains("filter_" + std::string{model}));
  }
  EXPECT_THAT(names, Not(Contains("lidar"))) << "a scene has none";
}

TEST_F(Compare, PrintsALinePerMethod) {
  EXPECT_THAT(outcome_->output, HasSubstr("4 frames, 4 with truth"));
  for (const Json& method : methods()) EXPECT_THAT(outcome_->output, HasSubstr(method["title"].get<std::string>()));
}

TEST_F(Compare, EveryMethodTellsObstaclesFromFreeSpace) {
  for (const Json& method : methods()) {
    EXPECT_GT(score(method, "auc"), 0.8) << method["name"];
    EXPECT_GT(score(method, "known"), 0.7) << method["name"];
    EXPECT_EQ(method["scores"]["3-20 m"]["frames"], 4) << method["name"];
  }
}

TEST_F(Compare, GivesTheSameFiguresAsRunAndEvaluate) {
  const TemporaryFolder folder;
  const std::string run{(folder / "run").string()};
  run_well({"run", scene(), "--out", run});
  run_well({"evaluate", run, scene(), "--json", (folder / "scores.json").string()});
  const Json evaluated(json_of(folder / "scores.json"));
  const std::string text{evaluated.dump()};
  for (const auto& [name, layer] : {std::pair{"observed", "observed"}, std::pair{"filter_joint", "occupancy"}}) {
    const Json& bands = evaluated["layers"][layer]["bands"];
    EXPECT_EQ(bands["3-20 m"]["auc"]["value"], method(name)["scores"]["3-20 m"]["auc"]["value"]) << text.substr(0, 600);
  }
}

TEST_F(Compare, DrawsContactSheets) {
  EXPECT_THAT(files_in(*folder_ / "pictures"), SizeIs(4));
}

TEST_F(Compare, RunsOnlyWhatIsAskedFor) {
  const TemporaryFolder folder;
  const std::string json{(folder / "scores.json").string()};
  run_well({"compare", scene(), "--frames", "1:2", "--only", "stixels,observed", "--json", json});
  const Json scores(json_of(json));
  EXPECT_EQ(scores["frames"], 2);
  ASSERT_EQ(scores["methods"].size(), 2U);
  EXPECT_EQ(scores["methods"][0]["name"], "observed");
  EXPECT_EQ(scores["methods"][1]["name"], "stixels");
}

TEST_F(Compare, ComplainsOfMethodsThatDoNotExist) {
  const Outcome outcome{run_tool({"compare", scene(), "--only", "stixel"})};
  EXPECT_EQ(outcome.exit_code, 64);
  EXPECT_THAT(outcome.errors, HasSubstr("stixel"));
  EXPECT_THAT(outcome.errors, HasSubstr("ray_casting_map"));
}

TEST_F(Compare, ComplainsWhereThereIsNoLidar) {
  for (const char* option : {"--truth=lidar", "--hold-out"}) {
    const Outcome outcome{run_tool({"compare", scene(), option})};
    EXPECT_EQ(outcome.exit_code, 65) << option;
    EXPECT_THAT(outcome.errors, HasSubstr("no lidar")) << option;
  }
}

TEST(CompareLidar, UsesTheSweepsOfADrive) {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  const fs::path data{named != nullptr ? fs::path{named}
                                       : fs::path{STEREOGRID_SOURCE_DIR}.parent_path() / "shared/data"};
  if (!fs::exists(data / "kitti_odo04")) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  const TemporaryFolder folder;
  const auto log_loss = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "compare", (data / "kitti_odo04").string(),  "--frames", "0:1", "--only", "lidar,stixels",
        "--json",  (folder / "scores.json").string()};
    words.insert(words.end(), more.begin(), more.end());
    run_well(words);
    const Json scores(json_of(folder / "scores.json"));
    EXPECT_EQ(scores["frames"], 2);
    EXPECT_EQ(scores["frames_with_truth"], 1) << "every second frame has a sweep";
    EXPECT_EQ(scores["methods"][0]["name"], "stixels");
    EXPECT_EQ(scores["methods"][1]["name"], "lidar");
    return scores["methods"][1]["scores"]["3-20 m"]["balanced_log_loss"]["value"].get<double>();
  };
  const double same_points{log_loss({})};
  const double held_out{log_loss({"--hold-out"})};
  EXPECT_LT(same_points, 0.2);
  EXPECT_LT(held_out, 0.3);
  EXPECT_GT(held_out, same_points);
}

}  // namespace
}  // namespace stereogrid::app::testing
