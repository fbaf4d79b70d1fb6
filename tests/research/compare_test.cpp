// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>

#include "../app/lidar_drive.hpp"
#include "../app/support.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

Outcome run_compare(const std::vector<std::string>& words) {
  return run_program(STEREOGRID_COMPARE, words);
}

Outcome compare_well(const std::vector<std::string>& words) {
  Outcome outcome{run_compare(words)};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  return outcome;
}

/// Four frames of a street, compared once for all tests.
class Compare : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    outcome_ = new Outcome{compare_well(
        {scene(), "--json", (*folder_ / "scores.json").string(), "--pictures", (*folder_ / "pictures").string()})};
  }
  static void TearDownTestSuite() {
    delete outcome_;
    delete folder_;
  }

  static std::string scene() { return "scene:street?frames=4&width=256&height=160"; }
  static Json methods() { return json_of(*folder_ / "scores.json")["series"]; }
  static double score(const Json& method, const std::string& figure) {
    return method["bands"]["3-20"][figure]["value"].get<double>();
  }

  static TemporaryFolder* folder_;
  static Outcome* outcome_;
};

TemporaryFolder* Compare::folder_{nullptr};
Outcome* Compare::outcome_{nullptr};

TEST_F(Compare, RunsEveryMethodAndFilterModel) {
  std::vector<std::string> names;
  const Json all(methods());
  for (const auto& [name, method] : all.items()) names.push_back(name);
  for (const char* name : {"observed", "observed_paper", "nearest_obstacle", "nearest_obstacle_paper",
                           "occupancy_boundary", "free_space", "stixels", "ray_casting", "ray_casting_map"}) {
    EXPECT_THAT(names, Contains(name));
  }
  for (const std::string_view model : names_of(FilterModel{})) {
    EXPECT_THAT(names, Contains("filter_" + std::string{model}));
  }
  EXPECT_THAT(names, Not(Contains("lidar"))) << "a scene has none";
}

TEST_F(Compare, PrintsALinePerMethod) {
  EXPECT_THAT(outcome_->output, HasSubstr("4 frames, 4 with truth"));
  const Json all(methods());
  for (const auto& [name, method] : all.items()) {
    EXPECT_THAT(outcome_->output, HasSubstr(method["title"].get<std::string>()));
  }
}

TEST_F(Compare, EveryMethodTellsObstaclesFromFreeSpace) {
  const Json all(methods());
  for (const auto& [name, method] : all.items()) {
    EXPECT_GT(score(method, "auc"), 0.8) << name;
    EXPECT_GT(score(method, "known"), 0.7) << name;
    EXPECT_EQ(method["bands"]["3-20"]["frames"], 4) << name;
    EXPECT_EQ(method["over_time"].get<bool>(), method.contains("motion")) << name;
  }
}

TEST_F(Compare, GivesTheSameFiguresAsRunAndEvaluate) {
  const TemporaryFolder folder;
  const std::string run{(folder / "run").string()};
  run_well({"run", scene(), "--out", run});
  run_well({"evaluate", run, scene(), "--json", (folder / "scores.json").string()});
  const Json evaluated(json_of(folder / "scores.json"));
  const Json compared(methods());
  for (const auto& [name, layer] : {std::pair{"observed", "observed"}, std::pair{"filter_joint", "occupancy"}}) {
    EXPECT_EQ(evaluated["series"][layer]["bands"], compared[name]["bands"]) << name;
  }
  EXPECT_EQ(evaluated["series"]["occupancy"]["motion"], compared["filter_joint"]["motion"]);
}

TEST_F(Compare, DrawsContactSheets) {
  EXPECT_THAT(files_in(*folder_ / "pictures"), SizeIs(4));
}

TEST_F(Compare, TakesOpencvsDisparities) {
  const TemporaryFolder folder;
  const std::string json{(folder / "scores.json").string()};
  for (const char* matcher : {"opencv-bm", "opencv-sgbm"}) {
    compare_well({scene(), "--matcher", matcher, "--only", "observed", "--json", json});
    const Json observed(json_of(json)["series"]["observed"]);
    EXPECT_GT(score(observed, "auc"), 0.8) << matcher;
    EXPECT_NE(score(observed, "auc"), score(methods()["observed"], "auc")) << matcher;
  }
  EXPECT_EQ(run_compare({scene(), "--matcher", "abacus"}).exit_code, 64);
  const std::string drive{(folder / "drive").string()};
  run_well({"simulate", scene(), "--out", drive});
  const Outcome outcome{run_compare({drive, "--disparities", drive + "/truth/disparity", "--matcher", "opencv-bm"})};
  EXPECT_EQ(outcome.exit_code, 64);
  EXPECT_THAT(outcome.errors, HasSubstr("needs right images"));
}

TEST(HoldOut, FusesEvenRingsAndScoresWithOddOnes) {
  const TemporaryFolder folder;
  const std::string drive{(folder / "drive").string()};
  put_lidar_drive(drive);
  const auto occupied_ahead = [&](const std::vector<std::string>& more, const char* method) {
    std::vector<std::string> words{drive,
                                   "--only",
                                   "fused,filter_fused,lidar",
                                   "--truth",
                                   "lidar",
                                   "--set",
                                   "fusion.stereo_confidence=0",
                                   "--json",
                                   (folder / "scores.json").string(),
                                   "--grids",
                                   (folder / "grids").string()};
    words.insert(words.end(), more.begin(), more.end());
    compare_well(words);
    const auto cells{io::read_npz(folder / "grids" / "000000.npz").at(method).to_image<float>()};
    const float* const row{cells.row(cells.height() / 2)};
    return *std::max_element(row + 35, row + 45);  // 7 to 9 m ahead, cells of 0.2 m
  };
  for (const char* method : {"fused", "lidar"}) {
    EXPECT_GT(occupied_ahead({}, method), 0.9F) << method;
    EXPECT_LT(occupied_ahead({"--hold-out"}, method), 0.5F) << method << ": the wall is in the odd rings";
    const Json bands(json_of(folder / "scores.json")["series"][method]["bands"]);
    EXPECT_GT(bands["3-20"]["occupied"], 50);
    EXPECT_EQ(bands["3-20 clear"]["occupied"], bands["3-20"]["occupied"]);
  }
  EXPECT_TRUE(json_of(folder / "scores.json")["series"].contains("filter_fused"));
}

TEST_F(Compare, RunsOnlyWhatIsAskedFor) {
  const TemporaryFolder folder;
  const std::string json{(folder / "scores.json").string()};
  compare_well({scene(), "--frames", "1:2", "--only", "stixels,observed", "--json", json});
  const Json scores(json_of(json));
  EXPECT_EQ(scores["about"]["frames"], "2 of 2");
  ASSERT_EQ(scores["series"].size(), 2U);
  EXPECT_TRUE(scores["series"].contains("observed"));
  EXPECT_TRUE(scores["series"].contains("stixels"));
}

TEST_F(Compare, WritesTheGridsOfEveryMethod) {
  const TemporaryFolder folder;
  const std::string run{(folder / "run").string()};
  const std::string grids{(folder / "grids").string()};
  run_well({"run", scene(), "--frames", "0:1", "--out", run});
  compare_well({scene(), "--frames", "0:1", "--only", "observed,nearest_obstacle", "--grids", grids});
  EXPECT_THAT(files_in(grids), ElementsAre("000000.npz", "000001.npz"));
  const Arrays ours(io::read_npz(folder / "run" / "grids" / "000001.npz"));
  const Arrays compared(io::read_npz(folder / "grids" / "000001.npz"));
  ASSERT_EQ(compared.size(), 2U) << "no sweep";
  EXPECT_EQ(compared.at("observed").bytes, ours.at("observed").bytes);
  EXPECT_EQ(compared.at("nearest_obstacle").shape, ours.at("observed").shape);
  EXPECT_NE(compared.at("nearest_obstacle").bytes, ours.at("observed").bytes);
}

TEST_F(Compare, ComplainsOfMethodsThatDoNotExist) {
  const Outcome outcome{run_compare({scene(), "--only", "stixel"})};
  EXPECT_EQ(outcome.exit_code, 64);
  EXPECT_THAT(outcome.errors, HasSubstr("stixel"));
  EXPECT_THAT(outcome.errors, HasSubstr("ray_casting_map"));
}

TEST_F(Compare, ComplainsWhereThereIsNoLidar) {
  for (const char* option : {"--truth=lidar", "--hold-out"}) {
    const Outcome outcome{run_compare({scene(), option})};
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
    std::vector<std::string> words{(data / "kitti_odo04").string(),
                                   "--frames",
                                   "0:1",
                                   "--only",
                                   "lidar,stixels",
                                   "--json",
                                   (folder / "scores.json").string(),
                                   "--grids",
                                   (folder / "grids").string()};
    words.insert(words.end(), more.begin(), more.end());
    compare_well(words);
    const Json scores(json_of(folder / "scores.json"));
    EXPECT_EQ(scores["about"]["frames"], "1 of 2") << "every second frame has a sweep";
    EXPECT_TRUE(scores["series"].contains("stixels"));
    EXPECT_THAT(io::read_npz(folder / "grids" / "000000.npz").at("sweep").shape, ElementsAre(Gt(10'000U), 3U));
    EXPECT_FALSE(io::read_npz(folder / "grids" / "000001.npz").contains("sweep"));
    return scores["series"]["lidar"]["bands"]["3-20"]["balanced_log_loss"]["value"].get<double>();
  };
  const double same_points{log_loss({})};
  const double held_out{log_loss({"--hold-out"})};
  EXPECT_LT(same_points, 0.2);
  EXPECT_LT(held_out, 0.3);
  EXPECT_GT(held_out, same_points);
}

}  // namespace
}  // namespace stereogrid::app::testing
