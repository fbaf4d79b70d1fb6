// SPDX-License-Identifier: Apache-2.0
//
// Standard streams that are closed, full, or whose reader has gone or stalls.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Streams = FolderTest;

const std::string tool{quoted(STEREOGRID_TOOL)};
constexpr const char* full{"/dev/full"};

/// A run that warns of a frame, with these redirections. Gives its folder.
int run_with_a_warning(const TemporaryFolder& folder, const fs::path& out, const std::string& redirections) {
  const fs::path drive{folder / "drive"};
  if (!fs::exists(drive)) {
    run_well({"simulate", small_scene("street", "&frames=4"), "--out", drive});
    fs::resize_file(drive / "left" / "000002.png", 100);
  }
  return shell(tool + " run " + quoted(drive.string()) + " --out " + quoted(out.string()) + " " + redirections);
}

TEST_F(Streams, ThatAreClosedAreNotMistakenForFilesOfTheRun) {
  ASSERT_EQ(run_with_a_warning(folder, folder / "open", ">/dev/null 2>&1"), 0);
  for (const std::string closed : {"2>&-", ">&-", "<&-", "<&- >&- 2>&-", "2>&- >/dev/null"}) {
    const fs::path out{folder / closed};
    EXPECT_EQ(run_with_a_warning(folder, out, closed + (closed.find("2>") == closed.npos ? " 2>/dev/null" : "")), 0);
    expect_equal_runs(folder / "open", out);
    EXPECT_THAT(text_of(out / "run.json"), StartsWith("{"));
  }
}

TEST_F(Streams, ErrorsThatNobodyCanReadKeepTheirExitCode) {
  for (const char* nowhere : {" 2>&-", " 2>/dev/full"}) {
    EXPECT_EQ(shell(tool + " fly" + nowhere), 64) << nowhere;
    EXPECT_EQ(shell(tool + " run /nowhere --out " + quoted((folder / "run").string()) + nowhere), 65) << nowhere;
    EXPECT_EQ(run_with_a_warning(folder, folder / nowhere, std::string{">/dev/null"} + nowhere), 0) << nowhere;
  }
}

/// Message with a full stdout.
Outcome with_full_output(const std::string& words) {
  const TemporaryFolder folder;
  const fs::path errors{folder / "errors"};
  Outcome outcome;
  outcome.exit_code = shell(tool + " " + words + " >" + full + " 2>" + quoted(errors.string()));
  outcome.errors = text_of(errors);
  return outcome;
}

TEST_F(Streams, AFullOutputIsAFailure) {
  const std::string scene{quoted(small_scene("street", "&frames=3"))};
  const std::string run{quoted((folder / "run").string())};
  const std::string drive{quoted((folder / "drive").string())};
  for (const std::string& words :
       {std::string{"config"}, std::string{"config --json"}, std::string{"config --markdown"}, std::string{"--help"},
        std::string{"run --help"}, std::string{"--version"}, "info " + scene, "run " + scene + " --out " + run,
        "evaluate " + run, "simulate " + scene + " --out " + drive}) {
    const Outcome outcome{with_full_output(words)};
    EXPECT_EQ(outcome.exit_code, 75) << words;
    EXPECT_THAT(outcome.errors, HasSubstr("standard output")) << words;
    EXPECT_THAT(outcome.errors, HasSubstr("No space left on device")) << words;
  }
  EXPECT_EQ(lines_of(folder / "run").size(), 3U);
  EXPECT_EQ(json_of(folder / "run" / "run.json")["frames"]["complete"], true);
}

TEST_F(Streams, AFullOutputHidesNoOtherFailure) {
  EXPECT_EQ(with_full_output("fly").exit_code, 64);
  EXPECT_EQ(with_full_output("info /nowhere").exit_code, 65);
}

TEST_F(Streams, AReaderThatHasEnoughEndsTheProgramQuietly) {
  const fs::path errors{folder / "errors"};
  const fs::path code{folder / "code"};
  signal(SIGPIPE, SIG_DFL);  // independent of the test's environment
  // true reads nothing; the shell returns 141
  shell("{ sleep 0.2; " + tool + " config --markdown; echo $? >" + quoted(code.string()) + "; } 2>" +
        quoted(errors.string()) + " | true");
  EXPECT_EQ(text_of(code), "141\n");
  EXPECT_EQ(text_of(errors), "");
}

/// A pipe whose reader stalls until read_rest(): nothing more can be written into it.
class StalledPipe {
 public:
  StalledPipe() {
    mkfifo(path_.c_str(), 0600);
    descriptor_ = open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    const std::string page(4096, '.');
    for (const std::size_t size : {page.size(), std::size_t{1}}) {
      while (write(descriptor_, page.data(), size) > 0) {
      }
    }
  }
  StalledPipe(const StalledPipe&) = delete;
  StalledPipe& operator=(const StalledPipe&) = delete;
  ~StalledPipe() { close(descriptor_); }

  [[nodiscard]] std::string name() const { return quoted(path_.string()); }

  /// Reads until the process ends. Returns what came after the filling, and its exit code.
  std::pair<std::string, std::optional<int>> read_rest(Process& process) const {
    std::string text;
    std::optional<int> code;
    for (int i{0}; i < 2000 && !code; ++i) {
      code = process.wait_for(std::chrono::milliseconds{5});
      std::string piece(65536, '\0');
      for (ssize_t count{0}; (count = read(descriptor_, piece.data(), piece.size())) > 0;) {
        text.append(piece, 0, static_cast<std::size_t>(count));
      }
    }
    return {text.substr(std::min(text.size(), text.find_first_not_of('.'))), code};
  }

 private:
  TemporaryFolder folder_;
  fs::path path_{folder_ / "pipe"};
  int descriptor_{-1};
};

/// The tool, with both streams redirected.
Process tool_into(const std::string& stream, const std::string& words) {
  return {"sh", {"-c", "exec " + tool + " " + words + " >" + stream + " 2>&1"}};
}

constexpr std::chrono::seconds far_more_than_a_stop_takes{20};

TEST_F(Streams, AStopWorksWhileTheirReaderStalls) {
  const auto name = [&](const char* part) { return quoted((folder / part).string()); };
  const std::string many{quoted(small_scene("street", "&frames=5000"))};
  run_well({"simulate", small_scene("street", "&frames=4"), "--out", folder / "drive", "--no-truth"});
  run_well({"run", folder / "drive", "--out", folder / "run", "--mcap", folder / "run.mcap"});
  const StalledPipe pipe;
  struct Case {
    std::string words;
    int code;
  };
  for (const Case& one : {Case{"live " + name("drive") + " --loop --listen :0 --mcap " + name("live.mcap"), 0},
                          Case{"view " + name("run.mcap") + " --listen :0", 0},
                          Case{"run " + many + " --verbose --out " + name("stopped"), 128 + SIGTERM}}) {
    Process process{tool_into(pipe.name(), one.words)};
    process.wait_until_it_catches_signals();
    if (one.words.starts_with("run ")) wait_for_frames(folder / "stopped", 3);
    process.send(SIGTERM);
    EXPECT_EQ(process.wait_for(far_more_than_a_stop_takes), one.code) << one.words;
  }
  EXPECT_EQ(json_of(folder / "stopped" / "run.json")["frames"]["done"], lines_of(folder / "stopped").size());
  EXPECT_THAT(text_of(folder / "live.mcap"), ::testing::EndsWith("\x89MCAP0\r\n")) << "closed";
}

TEST_F(Streams, ARunGoesOnWhileTheirReaderStalls) {
  const StalledPipe pipe;
  const std::string out{quoted((folder / "run").string())};
  Process process{tool_into(pipe.name(), "run " + quoted(small_scene("street", "&frames=9")) + " --out " + out)};
  EXPECT_EQ(process.wait_for(far_more_than_a_stop_takes), 75) << "its summary is lost";
  EXPECT_EQ(lines_of(folder / "run").size(), 9U);
  EXPECT_EQ(json_of(folder / "run" / "run.json")["frames"]["complete"], true);
}

TEST_F(Streams, NothingIsLostWhereTheReaderGoesOn) {
  const StalledPipe pipe;
  const std::string run{"run " + quoted(small_scene("street", "&frames=9")) + " --set grid.length_m=5 --out " +
                        quoted((folder / "run").string())};
  Process process{tool_into(pipe.name(), run)};
  wait_for_frames(folder / "run", 3);
  const auto [text, code]{pipe.read_rest(process)};
  EXPECT_EQ(code, 0);
  EXPECT_THAT(text, StartsWith("info: built-in scene: 9 frames"));
  EXPECT_THAT(text, HasSubstr("\n9 frames, 0 of 9 skipped"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("dropped")));
}

TEST_F(Streams, AnErrorWaitsForItsReaderButNotForever) {
  const StalledPipe pipe;
  Process patient{tool_into(pipe.name(), "info /nowhere")};
  EXPECT_EQ(patient.wait_for(far_more_than_a_stop_takes), 65);
  Process read_in_time{tool_into(pipe.name(), "info /nowhere")};
  std::this_thread::sleep_for(std::chrono::milliseconds{300});
  const auto [text, code]{pipe.read_rest(read_in_time)};
  EXPECT_EQ(code, 65);
  EXPECT_THAT(text, HasSubstr("/nowhere: there is no such file or folder"));
}

TEST_F(Streams, OutputWaitsForAReaderThatPages) {
  const StalledPipe pipe;
  Process process{tool_into(pipe.name(), "config --markdown")};
  EXPECT_EQ(process.wait_for(std::chrono::milliseconds{1500}), std::nullopt);
  const auto [text, code]{pipe.read_rest(process)};
  EXPECT_EQ(code, 0);
  EXPECT_EQ(text, run_well({"config", "--markdown"}).output);
}

}  // namespace
}  // namespace stereogrid::app::testing
