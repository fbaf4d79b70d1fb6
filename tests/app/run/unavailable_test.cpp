// SPDX-License-Identifier: Apache-2.0
//
// Files that were listed and cannot be opened or read, as on a network file system that is away for a moment: exit code
// 75, no frame is skipped, and --resume gives the bytes of a run that nothing disturbed.
#include "bags/bag_drive.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

/// A drive of which a file can be away: a symbolic link whose target is missing.
class Unavailable : public ::testing::Test {
 protected:
  void SetUp() override { run_well({"simulate", small_scene("street", "&frames=9"), "--out", drive(), "--no-truth"}); }

  [[nodiscard]] std::string drive() const { return (folder / "drive").string(); }
  [[nodiscard]] fs::path out(const std::string& name) const { return folder / name; }

  void take_away(const fs::path& file) const {
    fs::rename(folder / "drive" / file, folder / "away");
    fs::create_symlink(folder / "nowhere", folder / "drive" / file);
  }
  void put_back(const fs::path& file) const { fs::rename(folder / "away", folder / "drive" / file); }

  /// Frame 6 cannot be read, `file` being away; then it can. `done`: frames before it.
  void expect_goes_on(const Words& more, const fs::path& file, std::size_t done) const {
    const auto into = [&](const char* name) {
      return joined({"run", drive(), "--resume", "--checkpoint-every", "4", "--out", out(name)}, more);
    };
    run_well(into("whole"));
    take_away(file);
    const Outcome stopped{run_tool(into("stopped"))};
    EXPECT_EQ(stopped.exit_code, 75) << stopped.errors;
    EXPECT_THAT(stopped.errors,
                AllOf(HasSubstr(file.filename().string() + ": there is no such file"), HasSubstr("try again"),
                      HasSubstr(std::to_string(done) + " of 9 frames are done")));
    EXPECT_THAT(stopped.errors, Not(HasSubstr("skipped: ")));
    EXPECT_EQ(lines_of(out("stopped")).size(), done);
    const Json run(json_of(out("stopped") / "run.json"));
    EXPECT_EQ(run["frames"]["complete"], false);
    EXPECT_EQ(run["frames"]["skipped"], 0);
    put_back(file);
    run_well(into("stopped"));
    expect_equal_runs(out("whole"), out("stopped"));
    EXPECT_EQ(json_of(out("stopped") / "run.json")["frames"]["complete"], true);
  }

  const TemporaryFolder folder;
};

TEST_F(Unavailable, ALeftImageEndsTheRunAndItGoesOnLater) {
  expect_goes_on({}, "left/000006.png", 6);
}

TEST_F(Unavailable, ARightImageEndsARunWithOdometryAndItGoesOnLater) {
  expect_goes_on({"--poses", "odometry"}, "right/000006.png", 6);
}

TEST_F(Unavailable, ADisparityImageEndsTheRunAndItGoesOnLater) {
  run_well({"simulate", small_scene("street", "&frames=9"), "--out", folder / "truth"});
  fs::rename(folder / "truth" / "truth" / "disparity", folder / "drive" / "disparity");
  expect_goes_on({"--disparities", drive() + "/disparity"}, "disparity/000006.png", 6);
}

TEST_F(Unavailable, ALidarSweepEndsTheRunAndItGoesOnLater) {
  fs::create_directories(folder / "drive" / "velodyne");
  for (int i{0}; i < 9; ++i) {
    std::ofstream sweep{folder / "drive" / "velodyne" / ("00000" + std::to_string(i) + ".bin"), std::ios::binary};
    for (const float value : {8.0F, 0.5F * static_cast<float>(i), -0.5F, 0.3F}) {
      sweep.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  std::ofstream{folder / "drive" / "calib.txt"} << "P0: 80 0 80 0 0 80 50 0 0 0 1 0\nP1: 80 0 80 -40 0 80 50 0 0 0 1 "
                                                   "0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n";
  expect_goes_on({"--fuse", "lidar", "--calibration", drive() + "/calib.txt"}, "velodyne/000006.bin", 6);
}

TEST_F(Unavailable, AnImageThatIsLookedAtFirstEndsTheRunBeforeItBegins) {
  take_away("left/000000.png");
  const Outcome stopped{run_tool({"run", drive(), "--out", out("run")})};
  EXPECT_EQ(stopped.exit_code, 75) << stopped.errors;
  EXPECT_FALSE(fs::exists(out("run") / "run.json"));
}

TEST_F(Unavailable, AnImageEndsAReplay) {
  take_away("left/000006.png");
  EXPECT_THAT(errors_of(75, {"live", drive(), "--listen", ":0", "--speed", "10"}),
              HasSubstr("000006.png: there is no such file"));
}

#ifdef STEREOGRID_FAULTS_LIBRARY
/// The environment of a run in which a file cannot be read once another one exists.
std::string failing_disk(const fs::path& file, const fs::path& once) {
  return "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) +
         " STEREOGRID_FAULTS_READ=" + quoted(fs::canonical(file).string()) +
         " STEREOGRID_FAULTS_READ_AFTER=" + quoted(once.string());
}

TEST_F(Unavailable, ADiskThatFailsEndsTheRunAndItGoesOnLater) {
  const Words words{"run", drive(), "--out", out("run"), "--poses", "none"};
  const Outcome stopped{run_tool(words, failing_disk(folder / "drive" / "left" / "000007.png", drive()))};
  EXPECT_EQ(stopped.exit_code, 75) << stopped.errors;
  EXPECT_THAT(stopped.errors, AllOf(HasSubstr("000007.png: cannot be read (Input/output error)"),
                                    HasSubstr("7 of 9 frames are done; the same command with --resume continues")));
  run_well(joined(words, {"--resume"}));
  EXPECT_EQ(lines_of(out("run")).size(), 9U);
}

class UnavailableBags : public Bags {
 protected:
  /// More frames than a run reads ahead, and than SQLite keeps in memory.
  static std::vector<Entry> many_entries() {
    std::vector<Entry> all{entry("/left/camera_info", start_ns, info(false)),
                           entry("/right/camera_info", start_ns, info(true))};
    for (std::size_t i{0}; i < 80; ++i) {
      const auto later_ns{static_cast<std::int64_t>(i - i % frames) * step_ns};
      all.push_back(image("/left/image_rect", "left", i % frames, "mono8", later_ns));
      all.push_back(image("/right/image_rect", "right", i % frames, "mono8", later_ns));
    }
    return all;
  }

  static void expect_goes_on(const fs::path& path, const fs::path& file) {
    const fs::path whole{run_bag_well("whole", path)};
    ASSERT_EQ(lines_of(whole).size(), 80U);
    const fs::path second{out() / "grids" / files_in(whole / "grids")[1]};
    const Words words{"run", path, "--out", out(), "--poses", "none", "--resume"};
    EXPECT_THAT(errors_of(75, words, failing_disk(file, second)),
                AllOf(HasSubstr("cannot be read"), HasSubstr("of 80 frames are done")));
    EXPECT_EQ(json_of(out() / "run.json")["frames"]["skipped"], 0);
    EXPECT_LT(lines_of(out()).size(), 80U);
    run_well(words);
    expect_equal_runs(whole, out());
  }
};

TEST_F(UnavailableBags, AnMcapOnADiskThatFailsEndsTheRunAndItGoesOnLater) {
  write_mcap(bag(), many_entries());
  expect_goes_on(bag(), bag());
}

TEST_F(UnavailableBags, ADb3OnADiskThatFailsEndsTheRunAndItGoesOnLater) {
  write_db3(*folder / "db3", many_entries());
  expect_goes_on(*folder / "db3", *folder / "db3" / "bag_0.db3");
}
// Each query of a path of the input (stat, opendir, readdir and their like) fails once, as on a network file system
// that is away for a moment: the exit code is 75, and nothing is taken for missing or of another kind.
class Away : public Bags {
 protected:
  static constexpr std::size_t few{5};  // step where most queries are those of other kinds, too

  static fs::path path(const char* name) { return fs::canonical(folder->path()) / name; }

  /// Runs the command once for each of its queries below a folder, or every `step`-th one.
  static void expect_try_again(const Words& words, const fs::path& under, std::size_t step = 1) {
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

  static std::vector<std::string> queries_of(const Words& words, const fs::path& under) {
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
#endif

}  // namespace
}  // namespace stereogrid::app::testing
