// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Config, PageIsUpToDate) {
  const fs::path page{fs::path{STEREOGRID_SOURCE_DIR} / "docs" / "config.md"};
  EXPECT_EQ(run_well({"config", "--markdown"}).output, text_of(page))
      << "make it anew: stereogrid config --markdown > docs/config.md";
}

// docs/paper.md says of each parameter whether preset `paper` has it from the paper.
TEST(Config, ThePapersPageNamesEveryParameter) {
  const std::string page{text_of(fs::path{STEREOGRID_SOURCE_DIR} / "docs" / "paper.md")};
  const Json paper(Json::parse(run_well({"config", "--preset", "paper", "--json"}).output));
  ASSERT_GT(paper.size(), 5U);
  for (const auto& [group, parameters] : paper.items()) {
    if (page.find("`" + group + ".*`") != std::string::npos) continue;
    for (const auto& [name, value] : parameters.items()) EXPECT_THAT(page, HasSubstr("`" + group + "." + name + "`"));
  }
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
      run_well({"config", "--json", "--config", file, "--set", "grid.width_m=15", "--set", "tracking.confirm_frames=5"})
          .output));
  EXPECT_EQ(json["grid"]["length_m"], 35.0);
  EXPECT_EQ(json["grid"]["width_m"], 15.0);
  EXPECT_EQ(json["tracking"]["confirm_frames"], 5);
}

TEST(Config, PrintsAFileThatItReads) {
  const TemporaryFolder folder;
  const std::string file{(folder / "robot.yaml").string()};
  const std::string yaml{run_well({"config", "--preset", "robot", "--set", "grid.width_m=7", "--yaml"}).output};
  EXPECT_THAT(yaml, HasSubstr("width_m: 7"));
  std::ofstream{file} << yaml;
  EXPECT_EQ(run_well({"config", "--config", file, "--json"}).output,
            run_well({"config", "--preset", "robot", "--set", "grid.width_m=7", "--json"}).output);
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

TEST(Info, ReportsWhatIsThere) {
  const TemporaryFolder folder;
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", (folder / "drive").string()});
  const std::string said{run_well({"info", (folder / "drive").string()}).output};
  for (const char* part : {"plain folder", "3, 000000 to 000002", "160 × 100 px", "calibration.yaml", "poses.csv",
                           "10 frames per second", "100 × 100 cells", "3 can be used", "fine"}) {
    EXPECT_THAT(said, HasSubstr(part));
  }
}

TEST(Info, SaysWhichStepsAreVisibleAndProposesThePresetOfALowCamera) {
  const std::string scene{"scene:terrain?kind=flat&camera=robot&frames=2"};
  const std::string low{run_well({"info", scene}).output};
  EXPECT_THAT(low, HasSubstr("0.15/0.15 m at 4 m, 0.21/0.20 m at 6 m"));
  EXPECT_THAT(low, HasSubstr("--preset robot"));
  const std::string robot{run_well({"info", scene, "--preset", "robot"}).output};
  EXPECT_THAT(robot, HasSubstr("0.03/0.04 m at 1.2 m"));
  EXPECT_THAT(robot, Not(HasSubstr("--preset robot")));
}

TEST(Info, RejectsADamagedFrameAndStaysUsable) {
  const TemporaryFolder folder;
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", (folder / "drive").string()});
  fs::resize_file(folder / "drive" / "left" / "000001.png", 100);
  const std::string said{run_well({"info", (folder / "drive").string()}).output};
  EXPECT_THAT(said, HasSubstr("frame 000001 cannot be used"));
  EXPECT_THAT(said, HasSubstr("usable"));
}

constexpr const char* library_name{"libstereogrid_cuda.so"};

/// An installed program, started from another folder.
class Library : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const fs::path& folder : {bin(), prefix() / STEREOGRID_LIBRARY_FOLDER, elsewhere()})
      fs::create_directories(folder);
    fs::copy_file(STEREOGRID_TOOL, bin() / "stereogrid");
  }

  [[nodiscard]] fs::path prefix() const { return fs::canonical(folder_.path()) / "prefix"; }
  [[nodiscard]] fs::path bin() const { return prefix() / "bin"; }
  [[nodiscard]] fs::path elsewhere() const { return fs::canonical(folder_.path()) / "elsewhere"; }

  static void put_library(const fs::path& folder) { std::ofstream{folder / library_name} << "no library"; }

  /// Error of a run that requires the library; `program` as typed in the folder elsewhere.
  [[nodiscard]] std::string error_text(const std::string& program) const {
    const fs::path errors{folder_ / "errors"};
    const int code{shell("cd " + quoted(elsewhere().string()) +
                         " && unset STEREOGRID_CUDA_LIBRARY LD_LIBRARY_PATH && PATH=" + quoted(bin().string()) +
                         ":$PATH && " + program + " run " + quoted(small_scene("empty", "&frames=1")) +
                         " --device cuda --out ../run 2>" + quoted(errors.string()))};
    EXPECT_EQ(code, 75);
    return text_of(errors);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(Library, BesideTheProgramIsFoundHoweverTheProgramIsCalled) {
  put_library(bin());
  fs::create_symlink(bin() / "stereogrid", elsewhere() / "link");
  for (const char* program : {"stereogrid", "../prefix/bin/stereogrid", "./link", "\"$(command -v stereogrid)\""}) {
    EXPECT_THAT(error_text(program), HasSubstr((bin() / library_name).string() + " could not be loaded")) << program;
  }
}

TEST_F(Library, InThePrefixOfTheProgramIsFound) {
  put_library(prefix() / STEREOGRID_LIBRARY_FOLDER);
  EXPECT_THAT(error_text("stereogrid"),
              HasSubstr((bin() / ".." / STEREOGRID_LIBRARY_FOLDER / library_name).string() + " could not be loaded"));
}

TEST_F(Library, InTheCurrentFolderIsLeftAlone) {
  put_library(elsewhere());
  fs::create_directories(elsewhere() / ".." / STEREOGRID_LIBRARY_FOLDER);
  put_library(elsewhere() / ".." / STEREOGRID_LIBRARY_FOLDER);
  std::ofstream{elsewhere() / "stereogrid"} << "anything of that name";
  EXPECT_THAT(error_text("stereogrid"), Not(HasSubstr("could not be loaded")));
}

}  // namespace
}  // namespace stereogrid::app::testing
