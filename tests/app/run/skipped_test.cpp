// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Drives with many damaged frames.
#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;

/// A plain folder of empty images, but for those that `usable` frames have.
class Skipped : public ::testing::Test {
 protected:
  void make_drive(int frames, const std::vector<int>& usable) {
    run_well({"simulate", small_scene("street", "&frames=1"), "--out", (folder / "one").string(), "--no-truth"});
    fs::create_directories(drive() / "left");
    fs::create_directories(drive() / "right");
    fs::copy(folder / "one" / "calibration.yaml", drive() / "calibration.yaml");
    for (const char* side : {"left", "right"}) {
      for (int i{0}; i < frames; ++i) std::ofstream{drive() / side / file(i)};
      for (const int i : usable) {
        fs::copy(folder / "one" / side / "000000.png", drive() / side / file(i), fs::copy_options::overwrite_existing);
      }
    }
  }

  static std::string file(int index) {
    std::string number{std::to_string(index)};
    return number.insert(0, 6 - number.size(), '0') + ".png";
  }

  [[nodiscard]] fs::path drive() const { return fs::canonical(folder.path()) / "drive"; }
  [[nodiscard]] fs::path out() const { return fs::canonical(folder.path()) / "run"; }

  [[nodiscard]] std::vector<std::string> command(const std::string& more = "--quiet") const {
    return {"run", drive().string(), "--poses", "none", "--out", out().string(), more};
  }

  const TemporaryFolder folder;
};

#ifdef STEREOGRID_FAULTS_LIBRARY
// Each of them once wrote the list of all before it.
TEST_F(Skipped, ManyDoNotWriteRunJsonAsOften) {
  make_drive(300, {0, 150});
  const fs::path report{folder / "calls"};
  const Outcome outcome{
      run_tool(command(), "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) +
                              " STEREOGRID_FAULTS_UNDER=" + quoted(fs::canonical(folder.path()).string()) +
                              " STEREOGRID_FAULTS_REPORT=" + quoted(report.string()))};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  int written{0};
  std::istringstream calls{text_of(report)};
  for (std::string call; std::getline(calls, call);) {
    if (call.starts_with("rename ") && call.ends_with("/run.json")) ++written;
  }
  EXPECT_GE(written, 3);
  EXPECT_LE(written, 12);
  const Json run(json_of(out() / "run.json"));
  EXPECT_EQ(run["frames"]["done"], 2);
  EXPECT_EQ(run["frames"]["skipped"], 298);
  ASSERT_EQ(run["skipped"].size(), 298U);
  EXPECT_EQ(run["skipped"].back()["index"], 299);
}
#endif

// A killed run has not recorded all skipped frames.
TEST_F(Skipped, AreFoundAgainWhereAKilledRunHasNotNotedThem) {
  make_drive(12, {0, 4, 5, 9});
  run_well(command());
  const Json whole(json_of(out() / "run.json"));
  ASSERT_EQ(whole["skipped"].size(), 8U);
  for (const std::vector<int>& noted : {std::vector<int>{}, std::vector<int>{1, 7}}) {
    Json killed(whole);
    killed["skipped"] = Json::array();
    for (const Json& frame : whole["skipped"]) {
      if (std::ranges::find(noted, frame["index"].get<int>()) != noted.end()) killed["skipped"].push_back(frame);
    }
    std::ofstream{out() / "run.json"} << killed;
    run_well(command("--resume"));
    EXPECT_EQ(json_of(out() / "run.json")["skipped"], whole["skipped"]);
    EXPECT_EQ(lines_of(out()).size(), 4U);
  }
}

TEST_F(Skipped, WhoseFilesHaveBeenMendedSinceAreReported) {
  make_drive(3, {0, 2});
  run_well(command());
  Json killed(json_of(out() / "run.json"));
  killed["skipped"] = Json::array();
  std::ofstream{out() / "run.json"} << killed;
  for (const char* side : {"left", "right"}) {
    fs::copy(drive() / side / file(0), drive() / side / file(1), fs::copy_options::overwrite_existing);
  }
  run_well(command("--resume"));
  const Json run(json_of(out() / "run.json"));
  ASSERT_EQ(run["skipped"].size(), 1U);
  EXPECT_EQ(run["skipped"][0]["name"], "000001");
  EXPECT_THAT(run["skipped"][0]["reason"].get<std::string>(), HasSubstr("before it had noted why"));
}

}  // namespace
}  // namespace stereogrid::app::testing
