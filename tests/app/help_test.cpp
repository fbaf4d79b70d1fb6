// SPDX-License-Identifier: Apache-2.0
//
// --help, suggestions for misspelt words, completion.

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Config = FolderTest;
using Info = FolderTest;
using Preset = FolderTest;
using Simulate = FolderTest;

using ::testing::ContainsRegex, ::testing::Eq, ::testing::IsSupersetOf;

const std::vector<std::string> commands{"run",  "simulate", "evaluate", "export",      "info",
                                        "live", "view",     "config",   "nav2-params", "completion"};

std::vector<std::string> lines_of_text(const std::string& text) {
  std::istringstream stream{text};
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::size_t characters_of(const std::string& line) {
  return static_cast<std::size_t>(std::ranges::count_if(line, [](char byte) { return (byte & '\xc0') != '\x80'; }));
}

std::string help_of(const Words& command, const std::string& columns) {
  const Outcome outcome{run_tool(joined(command, {"--help"}), "COLUMNS=" + columns)};
  EXPECT_EQ(outcome.exit_code, 0);
  return outcome.output;
}

TEST(Help, FitsTheTerminal) {
  for (const std::size_t columns : {80U, 100U, 120U}) {
    std::vector<Words> all{{}};
    for (const std::string& command : commands) all.push_back({command});
    for (const Words& command : all) {
      for (const std::string& line : lines_of_text(help_of(command, std::to_string(columns)))) {
        EXPECT_LE(characters_of(line), columns) << line;
      }
    }
  }
  EXPECT_LT(lines_of_text(help_of({"run"}, "120")).size(), lines_of_text(help_of({"run"}, "80")).size());
  EXPECT_EQ(help_of({"run"}, "none"), help_of({"run"}, "80")) << "the width of a pipe";
}

TEST(Help, HasGroupsInTheOrderOfUse) {
  std::vector<std::string> titles;
  for (const std::string& line : lines_of_text(help_of({"run"}, "80"))) {
    if (!line.empty() && line.front() != ' ' && line.back() == ':') titles.push_back(line);
  }
  EXPECT_THAT(titles,
              ElementsAre("Output:", "Input:", "Grid and camera:", "Speed and device:", "Parts of a drive, long runs:",
                          "Depth, disparities, bags and videos:", "Contents of the files:", "Messages and ROS 2:",
                          "Page in the browser:", "General:", "Examples:"));
}

TEST(Help, NamesDefaultsAndValues) {
  EXPECT_THAT(help_of({"completion"}, "80"), HasSubstr("Usage: stereogrid completion bash|zsh|fish [OPTIONS]"));
  EXPECT_THAT(help_of({"run"}, "120"),
              AllOf(HasSubstr("Usage: stereogrid run INPUT [RIGHT] --out DIR"), HasSubstr("-o, --out DIR"),
                    HasSubstr("--preset default|robot|paper|auto"), HasSubstr("--fuse none|lidar"), HasSubstr("[100]"),
                    HasSubstr("--mcap [FILE.mcap]"), HasSubstr("-q, --quiet"), Not(HasSubstr("1000000000"))));
}

TEST(Suggestions, NameTheNearestOptionOrCommand) {
  EXPECT_THAT(errors_of(64, {"rnu", "scene:street"}), HasSubstr("rnu: unknown command. Did you mean 'run'?"));
  EXPECT_THAT(errors_of(64, {"frobnicate", "--help"}),
              HasSubstr("frobnicate: unknown command. Commands: run, simulate,"));
  EXPECT_THAT(errors_of(64, {"run", "scene:street", "--out", "x", "--pictres"}),
              AllOf(HasSubstr("--pictres: unknown option. Did you mean '--pictures'?"),
                    HasSubstr("'stereogrid run --help' lists all")));
  EXPECT_THAT(errors_of(64, {"run", "scene:street", "--ou", "x"}), HasSubstr("Did you mean '--out'?"));
  EXPECT_THAT(errors_of(64, {"run", "scene:street", "--presett=paper"}), HasSubstr("Did you mean '--preset'?"));
  EXPECT_THAT(errors_of(64, {"run", "scene:street", "--frobnicate"}), Not(HasSubstr("Did you mean")));
  EXPECT_THAT(errors_of(64, {"config", "paper"}), HasSubstr("paper: unexpected argument. Usage: stereogrid config"));
}

TEST(Suggestions, NameTheOptionWithTheInputAsItsValue) {
  EXPECT_THAT(errors_of(64, {"run", "--mcap", "scene:street", "--out", "x"}),
              AllOf(HasSubstr("INPUT is required"), HasSubstr("--mcap took 'scene:street'")));
}

/// Candidates for the last word, without descriptions.
std::vector<std::string> candidates(Words words) {
  words.insert(words.begin(), "__complete");
  std::vector<std::string> found{lines_of_text(run_well(words).output)};
  for (std::string& line : found) line = line.substr(0, line.find('\t'));
  return found;
}

TEST(Completion, KnowsCommandsOptionsAndValues) {
  EXPECT_THAT(candidates({""}), IsSupersetOf(commands));
  EXPECT_THAT(candidates({"si"}), ElementsAre("simulate"));
  EXPECT_THAT(candidates({"run", "--mcap-"}), ElementsAre("--mcap-topics"));
  EXPECT_THAT(candidates({"run", "--preset", ""}), ElementsAre("default", "robot", "paper", "auto"));
  EXPECT_THAT(candidates({"run", "--preset=r"}), ElementsAre("--preset=robot"));
  EXPECT_THAT(candidates({"run", "--device", "c"}), ElementsAre("cpu", "cuda"));
  EXPECT_THAT(candidates({"run", "--poses", ""}), ElementsAre("none", "file", "odometry", ":files"));
  EXPECT_THAT(candidates({"run", "--out", ""}), ElementsAre(":folders"));
  EXPECT_THAT(candidates({"run", "--set", "grid.le"}), ElementsAre("grid.length_m="));
  EXPECT_THAT(candidates({"run", "--set", "filter.model="}), Contains(Eq("filter.model=joint")));
  EXPECT_THAT(candidates({"run", "--layers", "age_s,vel"}), ElementsAre("age_s,velocity", "age_s,velocity_covariance"));
  EXPECT_THAT(candidates({"run", "scene:stre"}), ElementsAre(":files", "scene:street"));
  EXPECT_THAT(candidates({"run", "--mcap", "scene:stre"}), ElementsAre(":files", ":files", "scene:street"));
  EXPECT_THAT(candidates({"simulate", "cro"}), ElementsAre("crossing"));
  EXPECT_THAT(candidates({"completion", ""}), ElementsAre("bash", "zsh", "fish"));
  EXPECT_THAT(candidates({"run", "--frames", ""}), ElementsAre());
}

bool has_shell(const std::string& name) {
  return shell("command -v " + name + " >/dev/null") == 0;
}

/// Lines that a script prints in a shell with its completion.
std::vector<std::string> complete_in(const std::string& name, const std::string& script) {
  const TemporaryFolder folder;
  const fs::path file{folder / "complete"};
  std::ofstream{file} << run_well({"completion", name}).output;
  const std::string path{fs::path{STEREOGRID_TOOL}.parent_path().string() + ":/usr/bin:/bin"};
  return lines_of_text(run_program(name, {"-c", "source " + file.string() + "\n" + script}, "PATH=" + path).output);
}

TEST(Completion, OfBashStopsAtEqualsSignsAndColons) {
  if (!has_shell("bash")) GTEST_SKIP() << "no bash";
  const auto in_bash = [](const std::string& words) {
    return complete_in("bash",
                       "COMP_WORDS=(" + words +
                           ") COMP_LINE=${COMP_WORDS[*]}\n"
                           "COMP_LINE=${COMP_LINE// = /=} COMP_LINE=${COMP_LINE// : /:}\n"
                           "COMP_POINT=${#COMP_LINE} COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_stereogrid 2>/dev/null\n"
                           "printf '%s\\n' \"${COMPREPLY[@]}\"");
  };
  EXPECT_THAT(in_bash("stereogrid si"), ElementsAre("simulate"));
  EXPECT_THAT(in_bash("stereogrid run --set grid.le"), ElementsAre("grid.length_m="));
  EXPECT_THAT(in_bash("stereogrid run --preset = pa"), ElementsAre("paper"));
  EXPECT_THAT(in_bash("stereogrid info scene : cro"), Contains(Eq("crossing")));
}

TEST(Completion, OfZshDescribesOptions) {
  if (!has_shell("zsh")) GTEST_SKIP() << "no zsh";
  const auto in_zsh = [&](const std::string& words, const std::string& current) {
    return complete_in("zsh", "_describe() { print -l -- \"${(@P)2}\" }\ncompadd() { print -l -- \"$@\" }\nwords=(" +
                                  words + ") CURRENT=" + current + "\n_stereogrid");
  };
  EXPECT_THAT(in_zsh("stereogrid si", "2"), ElementsAre(StartsWith("simulate:Write")));
  EXPECT_THAT(in_zsh("stereogrid run --set grid.le", "4"), Contains(Eq("grid.length_m=")));
}

TEST(Completion, OfFishDescribesOptions) {
  if (!has_shell("fish")) GTEST_SKIP() << "no fish";
  EXPECT_THAT(complete_in("fish", "complete -C 'stereogrid si'"), ElementsAre(StartsWith("simulate\tWrite")));
  EXPECT_THAT(complete_in("fish", "complete -C 'stereogrid run --preset '"),
              IsSupersetOf({"default", "robot", "paper"}));
}

TEST_F(Config, PageIsUpToDate) {
  const fs::path page{fs::path{STEREOGRID_SOURCE_DIR} / "docs" / "config.md"};
  EXPECT_EQ(run_well({"config", "--markdown"}).output, text_of(page))
      << "make it anew: stereogrid config --markdown > docs/config.md";
}

// docs/paper.md says of each parameter whether preset `paper` has it from the paper.
TEST_F(Config, ThePapersPageNamesEveryParameter) {
  const std::string page{text_of(fs::path{STEREOGRID_SOURCE_DIR} / "docs" / "paper.md")};
  const Json paper(Json::parse(run_well({"config", "--preset", "paper", "--json"}).output));
  ASSERT_GT(paper.size(), 5U);
  for (const auto& [group, parameters] : paper.items()) {
    if (page.find("`" + group + ".*`") != std::string::npos) continue;
    for (const auto& [name, value] : parameters.items()) EXPECT_THAT(page, HasSubstr("`" + group + "." + name + "`"));
  }
}

TEST_F(Config, ShowsAPreset) {
  const Json json(Json::parse(run_well({"config", "--preset", "paper", "--json"}).output));
  EXPECT_EQ(json["filter"]["model"], "tay2008");
}

TEST_F(Config, TakesAFileAndThenSettings) {
  const std::string file{folder / "mine.yaml"};
  std::ofstream{file} << "grid: {length_m: 35, width_m: 25}\n";
  const Json json(Json::parse(
      run_well({"config", "--json", "--config", file, "--set", "grid.width_m=15", "--set", "tracking.confirm_frames=5"})
          .output));
  EXPECT_EQ(json["grid"]["length_m"], 35.0);
  EXPECT_EQ(json["grid"]["width_m"], 15.0);
  EXPECT_EQ(json["tracking"]["confirm_frames"], 5);
}

TEST_F(Config, PrintsAFileThatItReads) {
  const std::string file{folder / "robot.yaml"};
  EXPECT_THAT(errors_of(64, {"config", "--set", "tracking.confirm_frames=51", "--yaml"}),
              HasSubstr("tracking.confirm_frames"));
  const std::string yaml{run_well({"config", "--preset", "robot", "--set", "grid.width_m=7", "--yaml"}).output};
  EXPECT_THAT(yaml, HasSubstr("width_m: 7"));
  std::ofstream{file} << yaml;
  EXPECT_EQ(run_well({"config", "--config", file, "--json"}).output,
            run_well({"config", "--preset", "robot", "--set", "grid.width_m=7", "--json"}).output);
}

TEST_F(Simulate, WritesADriveThatRunReadsLikeTheScene) {
  const std::string scene{small_scene("street", "&frames=3")};
  run_well({"simulate", scene, "--out", folder / "drive"});
  EXPECT_THAT(files_in(folder / "drive"), ElementsAre("calibration.yaml", "left", "poses.csv", "right", "truth"));
  EXPECT_THAT(files_in(folder / "drive" / "left"), ElementsAre("000000.png", "000001.png", "000002.png"));
  run_well({"run", scene, "--out", folder / "a"});
  run_well({"run", folder / "drive", "--out", folder / "b"});
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

TEST_F(Simulate, ObeysItsOptions) {
  run_well({"simulate", "empty", "--out", folder / "drive", "--frames", "2", "--seed", "7", "--width", "96", "--height",
            "64", "--no-truth"});
  EXPECT_THAT(files_in(folder / "drive"), ElementsAre("calibration.yaml", "left", "poses.csv", "right"));
  EXPECT_EQ(files_in(folder / "drive" / "right").size(), 2U);
}

TEST_F(Info, ReportsWhatIsThere) {
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", folder / "drive"});
  const std::string said{run_well({"info", folder / "drive"}).output};
  EXPECT_THAT(said, ContainsRegex("rows +matched corners of both images differ by 0\\.[0-2][0-9] rows"));
  for (const char* part : {"plain folder", "3, 000000 to 000002", "160 × 100 px", "calibration.yaml", "poses.csv",
                           "10 frames per second", "100 × 100 cells", "3 can be used", "fine"}) {
    EXPECT_THAT(said, HasSubstr(part));
  }
}

TEST_F(Info, SaysWhichStepsAreVisibleAndProposesThePresetOfALowCamera) {
  const std::string scene{"scene:terrain?kind=flat&camera=robot&frames=2"};
  const std::string low{run_well({"info", scene}).output};
  EXPECT_THAT(low, HasSubstr("0.15/0.15 m at 4 m, 0.21/0.20 m at 6 m"));
  EXPECT_THAT(low, HasSubstr("--preset robot"));
  const std::string robot{run_well({"info", scene, "--preset", "robot"}).output};
  EXPECT_THAT(robot, HasSubstr("0.03/0.04 m at 1.2 m"));
  EXPECT_THAT(robot, Not(HasSubstr("--preset robot")));
}

// The preset that `info` proposes is the one that "auto" takes, in all commands and in the same words.
TEST_F(Preset, AutoIsThatOfTheCamerasHeightGivenOrEstimated) {
  const std::string scene{"scene:corridor?camera=robot&frames=4&width=320&height=200"};
  const std::string stated{"camera 0.35 m above the ground (calibration)"};
  EXPECT_THAT(run_well({"info", scene}).output, HasSubstr("--preset robot is made for a camera 0.35 m above"));
  EXPECT_THAT(run_well({"info", scene, "--preset", "auto"}).output,
              AllOf(HasSubstr("robot: " + stated), HasSubstr("cells of 0.05 m"), Not(HasSubstr("--preset robot"))));
  run_well({"simulate", scene, "--out", folder / "drive"});
  const fs::path calibration{folder / "drive" / "calibration.yaml"};
  edit(calibration, "\n *mount:[^\n]*(\n +[^\n]*)*", "");
  const Outcome run{run_tool({"run", folder / "drive", "--out", folder / "run", "--preset", "auto"})};
  EXPECT_THAT(run.errors, ContainsRegex("preset robot: camera 0\\.[34][0-9] m above the ground \\(estimated\\)"));
  EXPECT_EQ(json_of(folder / "run" / "run.json").at("preset"), "robot");
  EXPECT_EQ(json_of(folder / "run" / "run.json").at("config").at("grid").at("cell_size_m"), 0.05);
  const std::string info{run_well({"info", folder / "drive", "--preset", "auto"}).output};
  EXPECT_THAT(info, ContainsRegex("preset +robot: camera 0\\.[34][0-9] m above the ground \\(estimated\\)"));
}

TEST_F(Preset, AutoIsTheDefaultOfAHighCamera) {
  const Outcome run{run_tool({"run", small_scene("street", "&frames=1"), "--out", folder / "run", "--preset=auto"})};
  EXPECT_THAT(run.errors, HasSubstr("preset default: camera 1.25 m above the ground (calibration)"));
  EXPECT_EQ(json_of(folder / "run" / "run.json").at("preset"), "default");
}

TEST_F(Info, ReportsAWrongYawWhereCamerasOverlap) {
  const auto problem_of = [](const std::string& scene) {
    return run_well({"info", scene, "--set", "grid.rear_m=5"}).output;
  };
  EXPECT_THAT(problem_of("scene:empty?cameras=3&turn_deg=30&frames=3&width=384&height=240"),
              Not(HasSubstr("agree better")));
  const fs::path drive{folder / "drive"};
  run_well({"simulate", "scene:street?cameras=2&turn_deg=25&focal=256&frames=5", "--no-truth", "--out", drive});
  EXPECT_THAT(problem_of(drive.string()), Not(HasSubstr("agree better")));
  const fs::path file{drive / "camera1" / "calibration.yaml"};
  std::string text{text_of(file)};
  const std::size_t yaw{text.find("camera_yaw_rad: ") + 16};
  const double wrong_rad{std::stod(text.substr(yaw)) + 0.087};
  text.replace(yaw, text.find_first_of(",}\n", yaw) - yaw, std::to_string(wrong_rad));
  std::ofstream{file} << text;
  EXPECT_THAT(problem_of(drive.string()), ContainsRegex("agree better with camera1 turned by -[45]"));
}

TEST_F(Info, RejectsADamagedFrameAndStaysUsable) {
  run_well({"simulate", small_scene("street", "&frames=3"), "--out", folder / "drive"});
  fs::resize_file(folder / "drive" / "left" / "000001.png", 100);
  const std::string said{run_well({"info", folder / "drive"}).output};
  EXPECT_THAT(said, HasSubstr("frame 000001 cannot be used"));
  EXPECT_THAT(said, HasSubstr("usable"));
}

constexpr const char* library_name{"libstereogrid_cuda.so"};

/// An installed program, started from another folder.
struct Library : FolderTest {
  void SetUp() override {
    for (const fs::path& path : {bin(), prefix() / STEREOGRID_LIBRARY_FOLDER, elsewhere()})
      fs::create_directories(path);
    fs::copy_file(STEREOGRID_TOOL, bin() / "stereogrid");
  }

  [[nodiscard]] fs::path prefix() const { return fs::canonical(folder.path()) / "prefix"; }
  [[nodiscard]] fs::path bin() const { return prefix() / "bin"; }
  [[nodiscard]] fs::path elsewhere() const { return fs::canonical(folder.path()) / "elsewhere"; }

  static void put_library(const fs::path& where) { std::ofstream{where / library_name} << "no library"; }

  /// Error of a run that requires the library; `program` as typed in the folder elsewhere.
  [[nodiscard]] std::string error_text(const std::string& program) const {
    const fs::path errors{folder / "errors"};
    const int code{shell("cd " + quoted(elsewhere().string()) +
                         " && unset STEREOGRID_CUDA_LIBRARY LD_LIBRARY_PATH && PATH=" + quoted(bin().string()) +
                         ":$PATH && " + program + " run " + quoted(small_scene("empty", "&frames=1")) +
                         " --device cuda --out ../run 2>" + quoted(errors.string()))};
    EXPECT_EQ(code, 75);
    return text_of(errors);
  }
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
