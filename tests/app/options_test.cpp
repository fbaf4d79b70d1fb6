// SPDX-License-Identifier: Apache-2.0
//
// Options with values that make no sense, and signals that stop a run.
#include <signal.h>

#include "stereogrid/io/image_file.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Options = FolderTest;
using Signals = FolderTest;

TEST_F(Options, FramesOutOfRangeAreRefused) {
  const std::string out{folder / "run"};
  const std::string scene{small_scene("empty", "&frames=4")};
  const auto run = [&](const std::string& frames) { return Words{"run", scene, "--out", out, "--frames", frames}; };
  for (const char* frames : {"4", "4:9"}) {
    expect_refused({run(frames), "the input has 4 frames, 0 to 3"});
  }
  for (const char* frames : {"2:1", ":-1", "-1:", "1:2:3", "18446744073709551616:"}) {
    expect_refused({run(frames), "FIRST:LAST"});
  }
  EXPECT_FALSE(fs::exists(out));
  run_well(run("2:18446744073709551615"));
  EXPECT_EQ(lines_of(out).size(), 2U);
}

TEST_F(Options, SimulateRefusesWhatIsNoNumberOfFramesAndNoSeed) {
  const std::string out{folder / "drive"};
  const auto simulate = [&](const char* option, const std::string& value) {
    return Words{"simulate", "empty", "--out", out, "--width", "64", "--height", "48", option, value};
  };
  struct Option {
    const char* name;
    const char* range;
    std::vector<const char*> refused;
  };
  for (const Option& option : {Option{"--frames", "1 to 1000000", {"0", "-1", "1000001", "010"}},
                               Option{"--seed", "0 to 18446744073709551615", {"-1", "18446744073709551616"}},
                               Option{"--width", "16 to 8192", {"15", "1e2"}}}) {
    for (const std::string value : option.refused) {
      expect_refused({simulate(option.name, value),
                      std::string{option.name} + ": " + value + " is not a whole number from " + option.range});
    }
  }
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(Options, NumbersThatAreNoneAreRefused) {
  const std::string out{folder / "never"};
  for (const char* number : {"nan", "5.1", "1.6m"}) {
    const std::string said{std::string{"--camera-height: "} + number + " is not a number from 0.3 to 5"};
    expect_refused({{"evaluate", "no_run", "--camera-height", number}, said});
  }
  for (const char* threads : {"-1", "1025"}) {
    const std::string said{std::string{"--threads: "} + threads + " is not a whole number from 0 to 1024"};
    expect_refused({{"run", "scene:empty", "--out", out, "--threads", threads}, said});
  }
}

// Each value is within its range.
TEST_F(Options, AGridOfNoCellsIsRefused) {
  const std::string out{folder / "never"};
  const std::string scene{small_scene("empty", "&frames=1")};
  const std::string said{"grid.length_m is 1, grid.cell_size_m is 5: no cell along that side"};
  const auto with_grid = [](Words words) {
    words.insert(words.end(), {"--set", "grid.length_m=1", "--set", "grid.cell_size_m=5"});
    return words;
  };
  for (const Words& words : {Words{"run", scene, "--out", out},
                             {"run", scene, "--out", out, "--pictures"},
                             {"live", scene, "--listen", "127.0.0.1:0"}}) {
    expect_refused({with_grid(words), said});
  }
  EXPECT_FALSE(fs::exists(fs::path{out} / "run.json"));
}

TEST_F(Options, PicturesOfAWideGridAreNoWiderThanOthers) {
  const fs::path out{folder / "run"};
  run_well({"run", small_scene("empty", "&frames=1"), "--out", out, "--pictures", "--set", "grid.length_m=1", "--set",
            "grid.width_m=500", "--set", "grid.cell_size_m=1"});
  const fs::directory_iterator picture{out / "pictures"};
  const Image<std::uint8_t> read{io::read_grey(picture->path())};
  EXPECT_LT(read.width(), 4000);
}

TEST_F(Options, PicturesAreSvgOnRequest) {
  const fs::path out{folder / "run"};
  run_well({"run", small_scene("empty", "&frames=1"), "--out", out, "--pictures", "svg"});
  EXPECT_THAT(files_in(out / "pictures"), ElementsAre("000000.svg"));
  EXPECT_TRUE(text_of(out / "pictures" / "000000.svg").starts_with("<svg "));
  run_well({"run", "--pictures", small_scene("empty", "&frames=1"), "--out", folder / "before the input"});
  EXPECT_THAT(files_in(folder / "before the input" / "pictures"), ElementsAre("000000.png"));
  expect_refused({{"run", "scene:empty", "--out", folder / "never", "--pictures", "jpg"}, "jpg"});
}

TEST_F(Options, EmptyValuesAreRefused) {
  const std::string out{folder / "never"};
  const std::string said{"is empty"};
  for (const char* option : {"--config", "--video", "--calibration", "--poses", "--disparities", "--frames"}) {
    expect_refused({{"run", small_scene("empty", "&frames=1"), "--out", out, option, ""}, option + (": " + said)});
  }
  expect_refused({{"run", "scene:empty", "--out", ""}, "--out: " + said});
  expect_refused({{"run", "", "--out", out}, "INPUT: " + said});
  expect_refused({{"simulate", "empty", "--out", ""}, "--out: " + said});
  expect_refused({{"evaluate", "no_run", ""}, "INPUT: " + said});
  expect_refused({{"evaluate", "no_run", "--json", ""}, "--json: " + said});
  expect_refused({{"info", ""}, "INPUT: " + said});
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(Options, AFileWhereTheResultsShouldGoStaysAsItIs) {
  const fs::path file{folder / "a_file"};
  std::ofstream{file} << "text";
  for (const char* command : {"run", "simulate"}) {
    EXPECT_THAT(errors_of(75, {command, small_scene("empty", "&frames=1"), "--out", file}),
                AllOf(HasSubstr(file.string()), HasSubstr("the folder cannot be made")));
  }
  EXPECT_EQ(text_of(file), "text");
}

TEST_F(Options, OfScenesAreChecked) {
  const Refused refusals[]{{{"info", "scene:empty?frames=0"}, "frames is a whole number from 1 to 1000000", 65},
                           {{"info", "scene:empty?seed=-1"}, "seed is a whole number", 65},
                           {{"info", "scene:empty?width=0"}, "width is a whole number from 16 to 8192", 65},
                           {{"info", "scene:empty?rate=nan"}, "rate is a number from 0.1 to 1000", 65},
                           {{"info", "scene:empty?wdith=64"}, "there is no key \"wdith\"", 65},
                           {{"info", "scene:empty?width=64&width=65"}, "width is given twice", 65},
                           {{"info", "scene:empty?seed=1&seed=1"}, "seed is given twice", 65}};
  for (const Refused& refused : refusals) expect_refused(refused);
}

TEST_F(Options, HelpAndVersionAreGiven) {
  EXPECT_THAT(run_well({"--version"}).output, HasSubstr("stereogrid "));
  EXPECT_THAT(run_well({"run", "--help"}).output, HasSubstr("--save-stages"));
  const std::string help{run_well({"--help"}).output};
  for (const char* code : {"0 ", "64 ", "65 ", "70 ", "75 ", "129", "130", "141", "143"}) {
    EXPECT_THAT(help.substr(help.find("Exit codes")), HasSubstr(code));
  }
}

std::vector<std::string> long_run(const fs::path& out, const std::string& frames = ":") {
  return {"run", small_scene("street", "&frames=400"), "--out", out, "--resume", "--frames", frames};
}

TEST_F(Signals, LeaveWholeFramesAndARunThatGoesOn) {
  for (const int signal : {SIGHUP, SIGINT, SIGTERM}) {
    const fs::path out{folder / std::to_string(signal)};
    Process process{long_run(out)};
    wait_for_frames(out, 2);
    process.send(signal);
    EXPECT_EQ(process.wait(), 128 + signal);
    const std::size_t done{lines_of(out).size()};
    EXPECT_LT(done, 400U);
    EXPECT_EQ(json_of(out / "run.json")["frames"]["done"], done);
    EXPECT_EQ(json_of(out / "run.json")["frames"]["complete"], false);
    EXPECT_EQ(files_in(out / "grids").size(), done);
    run_well(long_run(out, ":" + std::to_string(done)));
    EXPECT_EQ(lines_of(out).size(), done + 1);
  }
}

TEST_F(Signals, AHangupThatNohupIgnoresStopsNothing) {
  const fs::path out{folder / "run"};
  Process process{long_run(out, ":9"), SIGHUP};
  wait_for_frames(out, 1);
  process.send(SIGHUP);
  EXPECT_EQ(process.wait(), 0);
  EXPECT_EQ(lines_of(out).size(), 10U);
}

}  // namespace
}  // namespace stereogrid::app::testing
