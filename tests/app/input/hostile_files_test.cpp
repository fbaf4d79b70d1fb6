// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>
#include <sys/wait.h>

#include "support.hpp"

// The tool names the file, the fault and the remedy for any content. It never ends with an internal error (70) or a
// signal, and never hangs.
namespace stereogrid::app::testing {
namespace {

void put(const fs::path& path, const std::string& text) {
  std::ofstream{path, std::ios::binary} << text;
}

/// A drive of three frames and its run, made once; each test spoils a copy.
struct HostileFiles : FolderTest {
  static void SetUpTestSuite() {
    whole_ = new TemporaryFolder;
    run_well({"simulate", small_scene("street", "&frames=3"), "--out", *whole_ / "drive"});
    run_well({"run", *whole_ / "drive", "--out", *whole_ / "run"});
  }
  static void TearDownTestSuite() { delete whole_; }

  void SetUp() override { renew(); }
  void renew() const {
    for (const char* const part : {"drive", "run"}) {
      fs::remove_all(folder / part);
      fs::copy(*whole_ / part, folder / part, fs::copy_options::recursive);
    }
  }

  [[nodiscard]] std::string drive() const { return (folder / "drive").string(); }
  [[nodiscard]] std::string run() const { return (folder / "run").string(); }

  /// Expects the tool to end with the exit code and to say all parts. It must not hang.
  static void expect(int exit_code, const Words& words, const std::vector<std::string>& parts) {
    const Outcome outcome{run_tool(words, "timeout 60")};
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.errors;
    for (const std::string& part : parts) EXPECT_THAT(outcome.errors, HasSubstr(part));
  }
  void expect_evaluate(const std::vector<std::string>& parts) const { expect(65, {"evaluate", run(), drive()}, parts); }
  /// Options of the drive of the run, which stays valid.
  [[nodiscard]] std::vector<std::string> resume_words() const {
    return {"run", *whole_ / "drive", "--out", run(), "--resume"};
  }
  void expect_resume(int exit_code, const std::vector<std::string>& parts) const {
    expect(exit_code, resume_words(), parts);
  }

  static TemporaryFolder* whole_;
};
TemporaryFolder* HostileFiles::whole_{nullptr};

TEST_F(HostileFiles, ADriveWhoseNamesAreNoUtf8) {
  const fs::path strange{folder / "dr\xffive"};
  fs::rename(folder / "drive", strange);
  for (const char* const side : {"left", "right"})
    fs::rename(strange / side / "000001.png", strange / side / "fr\xe4me.png");
  fs::remove(strange / "poses.csv");
  const fs::path out{folder / "out"};
  const Words words{"run", strange, "--out", out};
  run_well(words);
  EXPECT_TRUE(fs::exists(out / "grids" / "fr\\xE4me.npz"));
  const std::vector<Json> lines(lines_of(out));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines.back()["name"], "fr\\xE4me");
  EXPECT_EQ(json_of(out / "run.json")["input"]["paths"][0].get<std::string>().ends_with("dr\\xFFive"), true);
  run_well(joined(words, {"--resume"}));
}

TEST_F(HostileFiles, RunJsonOfTheWrongShape) {
  const fs::path file{folder / "run" / "run.json"};
  for (const std::string& text :
       Words{"", "[]", "null", "3", "\"text\"", "{}", "{\"grid\": []}", "\xff", std::string(1'000'000, '['),
             "{\"frames\": [1]}", "{\"skipped\": 3, \"frames\": 3}"}) {
    put(file, text);
    expect_evaluate({"run.json", "Give the folder"});
  }
  for (const std::string& text : Words{"[]", "\xff", std::string(1'000'000, '['), R"({"frames": [1]})"}) {
    put(file, text);
    expect_resume(65, {"run.json: is n", "Start the run anew"});  // not understood, or nested too deeply
  }
}

TEST_F(HostileFiles, RunJsonWithNumbersThatCannotBe) {
  const fs::path file{folder / "run" / "run.json"};
  const Json whole(json_of(file));
  for (const auto& [key, values] :
       std::map<std::string, std::vector<Json>>{{"/grid/cell_size_m", {0, -1, nullptr, 1e-9, "0.2"}},
                                                {"/grid/nx", {0, -3, 1'000'000'000, 1e300}},
                                                {"/grid/x_min_m", {nullptr, 1e300}},
                                                {"/rig/width_px", {-1, 0, 1e300, "640"}},
                                                {"/input", {nullptr, Json::array()}},
                                                {"/input/paths", {Json::array(), nullptr, "a", Json::array({1})}},
                                                {"/preset", {3}}}) {
    for (const Json& value : values) {
      Json bad(whole);
      bad[Json::json_pointer{key}] = value;
      put(file, bad.dump());
      expect(65, {"evaluate", run()}, {"run.json"});
    }
  }
  Json bad(whole);
  bad["input"]["paths"] = {std::string(5000, 'x')};
  put(file, bad.dump());
  expect(65, {"evaluate", run()}, {"is not there any more"});
  for (const Json& skipped :
       {Json::array({3}), Json::array({{{"index", -1}}}), Json::array({{{"index", "a"}}}), Json("a")}) {
    bad = whole;
    bad["skipped"] = skipped;
    put(file, bad.dump());
    expect_resume(65, {"run.json"});
  }
}

TEST_F(HostileFiles, RunJsonLost) {
  fs::remove(folder / "run" / "run.json");
  expect_evaluate({"run.json: is missing, but there are frames", "Put it back"});
  const std::string lines{text_of(folder / "run" / "frames.jsonl")};
  expect_resume(65, {"run.json: is missing", "frames.jsonl", "Put it back"});
  EXPECT_EQ(text_of(folder / "run" / "frames.jsonl"), lines);
  fs::remove(folder / "run" / "frames.jsonl");
  expect_resume(65, {"run.json: is missing", "grids"});
  expect(64, {"run", drive(), "--out", run()}, {"already holds a run (grids)"});
  EXPECT_EQ(files_in(folder / "run" / "grids").size(), 3U);
  EXPECT_FALSE(fs::exists(folder / "run" / "run.json"));
}

TEST_F(HostileFiles, FramesOfARunTwiceOrOutOfOrderOrOfTheWrongShape) {
  const fs::path file{folder / "run" / "frames.jsonl"};
  const std::string text{text_of(file)};
  std::vector<std::string> lines;
  for (const Json& line : lines_of(folder / "run")) lines.push_back(line.dump() + "\n");
  const auto with{[&](const std::string& key, const Json& value) {
    Json line(Json::parse(lines[1]));
    line[Json::json_pointer{key}] = value;
    return lines[0] + line.dump() + "\n";
  }};
  for (const std::string& bad :
       std::vector<std::string>{lines[0] + lines[0], lines[1] + lines[0], lines[0] + "\n", lines[0] + "[]\n",
                                lines[0] + std::string(1'000'000, '[') + "\n", lines[0] + "\xff\n", with("/index", -1),
                                with("/index", 1e300), with("/obstacles", Json::array({3}))}) {
    put(file, bad);
    expect_evaluate({"frames.jsonl: line 2 is"});
    expect_resume(65, {"frames.jsonl: line 2 is"});
    EXPECT_EQ(text_of(file), bad) << "what is there stays";
  }
  for (const std::string& bad :
       {with("/name", "000000"), with("/name", "../x"), with("/name", 3), with("/stamp_ns", 1e300)}) {
    put(file, bad);
    expect_evaluate({"frames.jsonl: line 2 is not understood"});
  }
  put(file, text);
  expect(64, joined(resume_words(), {"--frames", "0:1"}), {"frames.jsonl holds frames 0 to 2"});
}

TEST_F(HostileFiles, ACalibrationThatIsAFifo) {
  const fs::path file{folder / "drive" / "calibration.yaml"};
  fs::remove(file);
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  expect(65, {"info", drive()}, {"calibration.yaml", "FIFO"});
}

TEST_F(HostileFiles, SettingsThatEndedTheProgram) {
  const std::string file{folder / "c.yaml"};
  const Words words{"config", "--config", file};
  put(file, "grid: {length_m: .nan}\n");
  expect(64, words, {"c.yaml", "grid.length_m"});
  expect(65, {"config", "--config", "/dev/zero"}, {"/dev/zero", "device"});
  expect(65, {"config", "--config", run()}, {"is a folder"});
  for (const auto& [setting, said] :
       std::vector<std::pair<std::string, std::string>>{{"grid.length_m=nan", "grid.length_m is nan and must lie in"},
                                                        {"grid.length_m=inf", "grid.length_m is inf and must lie in"},
                                                        {"grid=3", "'grid' is a group of parameters"},
                                                        {"grid=3", "grid.length_m, grid.width_m"},
                                                        {"=3", "has no name: it is group.name"},
                                                        {"grid.length_m=", "grid.length_m has no value"}}) {
    expect(64, {"run", drive(), "--out", folder / "out", "--set", setting}, {said});
  }
}

TEST_F(HostileFiles, LidarWithoutPosition) {
  fs::create_directory(folder / "drive" / "velodyne");
  put(folder / "drive" / "velodyne" / "000000.bin", std::string(1600, '\x3f'));
  expect(65, {"run", drive(), "--out", folder / "out", "--fuse", "lidar"}, {"calibration.yaml", "A line Tr"});
}

TEST_F(HostileFiles, LinksThatGoInACircle) {
  fs::create_symlink("circle", folder / "circle");
  const std::string circle{folder / "circle"};
  expect(75, {"run", drive(), "--out", circle}, {"circle", "cannot be made"});
  expect(75, {"run", drive(), "--out", circle, "--resume"}, {"circle", "cannot be made"});
  expect(65, {"evaluate", circle}, {"circle"});
  expect(65, {"info", circle}, {"circle"});
  EXPECT_TRUE(fs::is_symlink(folder / "circle"));
}

TEST_F(HostileFiles, ResultsAreNotWrittenOverWhatIsNoFile) {
  const auto with{[&](const fs::path& path) { return Words{"evaluate", run(), drive(), "--json", path.string()}; }};
  fs::create_symlink("target.json", folder / "link.json");
  run_well(with(folder / "link.json"));
  EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
  EXPECT_EQ(json_of(folder / "target.json")["about"]["truth"], "exact");
  // as /dev/stdout, which a mistake would cost the machine
  fs::create_symlink("/proc/self/fd/1", folder / "stdout");
  const Outcome printed{run_well(with(folder / "stdout"))};
  EXPECT_THAT(printed.output, HasSubstr("log-loss")) << "the table";
  EXPECT_LT(printed.output.find("log-loss"), printed.output.find("\"about\":")) << "and behind it the JSON";
  expect(75, with(folder / "run"), {"is a folder"});
}

TEST_F(HostileFiles, AFileThatMayNotGrowIsNoReasonToBeKilled) {
  const std::string command{"(ulimit -f 8; " + quoted(STEREOGRID_TOOL) + " run " + quoted(drive()) + " --out " +
                            quoted((folder / "out").string()) + " 2>" + quoted((folder / "err").string()) + ")"};
  const int status{std::system(command.c_str())};
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 75);
  EXPECT_THAT(text_of(folder / "err"), HasSubstr("cannot be written"));
}

}  // namespace
}  // namespace stereogrid::app::testing
