// SPDX-License-Identifier: Apache-2.0
//
// Each query of a path of the input (stat, opendir, readdir and their like) fails once, as on a network file system
// that is away for a moment: the exit code is 75, and nothing is taken for missing or of another kind.
#include "bags/bag_drive.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

class Away : public Bags {
 protected:
  static constexpr std::size_t few{5};  // step where most queries are those of other kinds, too

  static fs::path path(const char* name) { return fs::canonical(folder->path()) / name; }

  /// Runs the command once for each of its queries below a folder, or every `step`-th one.
  static void expect_try_again(const std::vector<std::string>& words, const fs::path& under, std::size_t step = 1) {
    const std::vector<std::string> queries{queries_of(words, under)};
    ASSERT_FALSE(queries.empty());
    for (std::size_t i{0}; i < queries.size(); i += step) {
      fs::remove_all(path("out"));
      const Outcome outcome{run_tool(words, environment(under, i + 1))};
      EXPECT_EQ(outcome.exit_code, 75) << "query " << i + 1 << ": " << queries[i] << '\n' << outcome.errors;
      EXPECT_THAT(outcome.errors, HasSubstr("try again")) << queries[i];
    }
  }

 private:
  static std::string environment(const fs::path& under, std::size_t call) {
    return "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) +
           " STEREOGRID_FAULTS_OF=queries STEREOGRID_FAULTS_UNDER=" + quoted(under.string()) +
           " STEREOGRID_FAULTS_REPORT=" + quoted(path("queries").string()) +
           " STEREOGRID_FAULTS_KIND=" + (call % 2 == 0 ? "EIO" : "ESTALE") +
           " STEREOGRID_FAULTS_CALL=" + std::to_string(call);
  }

  static std::vector<std::string> queries_of(const std::vector<std::string>& words, const fs::path& under) {
    fs::remove_all(path("out"));
    fs::remove(path("queries"));
    const Outcome outcome{run_tool(words, environment(under, 0))};
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    std::vector<std::string> queries;
    std::ifstream file{path("queries")};
    for (std::string line; std::getline(file, line);) queries.push_back(line);
    return queries;
  }
};

TEST_F(Away, APlainFolder) {
  const std::string drive{path("drive")};
  expect_try_again({"run", drive, "--frames", "0:1", "--out", path("out")}, drive);
}

TEST_F(Away, ImagesWithDisparities) {
  const fs::path drive{path("given")};
  run_well({"simulate", small_scene("street", "&frames=2"), "--out", drive});
  fs::rename(drive / "truth" / "disparity", drive / "disparity");
  expect_try_again({"info", drive, "--disparities", drive / "disparity"}, drive, few);
}

TEST_F(Away, ADriveOfKitti) {
  const fs::path drive{path("kitti")};
  fs::create_directories(drive / "velodyne");
  fs::copy(path("drive") / "left", drive / "image_0");
  fs::copy(path("drive") / "right", drive / "image_1");
  fs::copy(path("drive") / "calibration.yaml", drive);
  expect_try_again({"info", drive}, drive, few);
}

TEST_F(Away, BagsInAFile) {
  fs::create_directory(path("bags"));
  const fs::path bag{path("bags") / "bag.mcap"};
  write_mcap(bag, entries({}));
  expect_try_again({"info", bag}, bag.parent_path());
}

TEST_F(Away, BagsInAFolder) {
  const fs::path bag{path("db3")};
  write_db3(bag, entries({}));
  expect_try_again({"info", bag}, bag);
}

TEST_F(Away, ARunThatIsEvaluatedOrExported) {
  const fs::path drive{path("scored")};
  const fs::path run{path("run")};
  run_well({"simulate", small_scene("street", "&frames=2"), "--out", drive});
  run_well({"run", drive, "--out", run});
  expect_try_again({"evaluate", run}, run);
  expect_try_again({"evaluate", run}, drive, few);
  expect_try_again({"export", run, "--laserscan", path("out")}, run);
}

}  // namespace
}  // namespace stereogrid::app::testing
