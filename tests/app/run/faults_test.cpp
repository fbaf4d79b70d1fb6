// SPDX-License-Identifier: Apache-2.0
//
// Every call that changes a run's files fails once, in every way (faults/faults.cpp), and the process is killed at any
// moment. The remaining frames are complete, the exit code is right, and --resume gives the bytes of an undisturbed
// run. The fast tests try some calls, those of EveryFault all of them.
#include <signal.h>

#include <iostream>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

constexpr std::size_t frames{10};

Words command(const fs::path& out) {
  return joined(
      {"run", "scene:street?frames=10&width=160&height=96", "--out", out, "--resume", "--quiet"},
      {"--checkpoint-every", "4", "--set", "grid.length_m=10", "--set", "grid.width_m=10", "--device", "cpu"});
}

/// A call that fails: which one, counted from 1, and how.
struct Fault {
  int call{0};
  std::string kind;
};

class Faults : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    calls_ = counted_calls("whole");
    expect_whole_frames(whole());
    make_half(path("half"));
    half_calls_ = counted_calls("half");
  }

  static fs::path path(const std::string& name) { return fs::canonical(folder->path()) / name; }
  static fs::path whole() { return path("whole"); }

  /// Calls of a run from its beginning: "write /…/frames.jsonl" and so on.
  static const std::vector<std::string>& calls() { return calls_; }
  /// Calls of a resumed run.
  static const std::vector<std::string>& half_calls() { return half_calls_; }

  static std::string environment(const fs::path& out, const Fault& fault, const fs::path& report = {}) {
    return "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) + " STEREOGRID_FAULTS_UNDER=" + quoted(out.string()) +
           " STEREOGRID_FAULTS_CALL=" + std::to_string(fault.call) + " STEREOGRID_FAULTS_KIND=" + quoted(fault.kind) +
           " STEREOGRID_FAULTS_REPORT=" + quoted(report.string());
  }

  /// Folder of a killed run: some frames, and the beginning of a line.
  static void make_half(const fs::path& out) {
    fs::copy(whole(), out, fs::copy_options::recursive);
    const std::string lines{text_of(whole() / "frames.jsonl")};
    std::ofstream{out / "frames.jsonl", std::ios::binary | std::ios::trunc} << lines.substr(0, lines.size() / 2);
  }

  /// Makes a call of a run fail (`half`: of a resumed one), then continues undisturbed.
  static void try_fault(const Fault& fault, bool half = false) {
    const std::string& call{(half ? half_calls_ : calls_)[static_cast<std::size_t>(fault.call) - 1]};
    SCOPED_TRACE(fault.kind + " of call " + std::to_string(fault.call) + ": " + call + (half ? " (going on)" : ""));
    const fs::path out{path("try")};
    fs::remove_all(out);
    if (half) make_half(out);
    const Outcome outcome{run_tool(command(out), environment(out, fault))};
    expect_exit_code(fault, outcome);
    expect_whole_frames(out);
    run_well(command(out));
    expect_equal_runs(whole(), out);
    EXPECT_THAT(files_in(out), files_in(whole()));
    EXPECT_EQ(json_of(out / "run.json")["frames"]["complete"], true);
  }

  /// True if the call can fail in this way.
  static bool makes_sense(const std::string& call, const std::string& kind) {
    const std::string name{call.substr(0, call.find(' '))};
    if (kind == "EINTR") return name == "open" || name == "write" || name == "close" || name == "fsync";
    return (kind != "short" && kind != "full") || name == "write";
  }

  static constexpr const char* kinds[]{"EIO", "ENOSPC", "EINTR", "short", "full", "kill"};

 private:
  static std::vector<std::string> counted_calls(const std::string& name) {
    const fs::path report{path(name + ".calls")};
    const Outcome outcome{run_tool(command(path(name)), environment(path(name), {0, "EIO"}, report))};
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    std::vector<std::string> calls;
    std::ifstream file{report};
    for (std::string line; std::getline(file, line);) calls.push_back(line);
    return calls;
  }

  static void expect_exit_code(const Fault& fault, const Outcome& outcome) {
    if (fault.kind == "EINTR" || fault.kind == "short") {
      EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
      EXPECT_THAT(outcome.errors, IsEmpty());
    } else if (fault.kind == "kill") {
      EXPECT_EQ(outcome.exit_code, 128 + SIGKILL);
    } else {
      EXPECT_EQ(outcome.exit_code, 75) << outcome.errors;
      EXPECT_THAT(outcome.errors, HasSubstr(fault.kind == "EIO" ? "Input/output error" : "No space left on device"));
    }
  }

  /// Files with their final name are complete; frames with a line have all files.
  static void expect_whole_frames(const fs::path& out) {
    for (const std::string& name : files_in(out / "grids")) {
      if (name.front() == '.') continue;  // a temporary name
      EXPECT_TRUE(text_of(out / "grids" / name) == text_of(whole() / "grids" / name)) << name;
    }
    std::istringstream lines{text_of(out / "frames.jsonl")};
    for (std::string line; std::getline(lines, line) && !lines.eof();) {
      const Json frame(Json::parse(line));
      EXPECT_TRUE(fs::exists(out / "grids" / (frame["name"].get<std::string>() + ".npz"))) << line;
    }
    EXPECT_TRUE(!fs::exists(out / "run.json") || json_of(out / "run.json").contains("frames"));
  }

  static inline Words calls_;
  static inline Words half_calls_;
};

/// Number of calls by name.
std::map<std::string, int> tally(const std::vector<std::string>& calls) {
  std::map<std::string, int> counts;
  for (const std::string& call : calls) ++counts[call.substr(0, call.find(' '))];
  return counts;
}

// Else the others might try nothing.
TEST_F(Faults, AreTriedOnEveryFileOfTheRun) {
  std::map<std::string, int> counts{tally(calls())};
  EXPECT_EQ(counts["mkdir"], 2);
  EXPECT_EQ(counts["rename"], static_cast<int>(frames) + 4);
  EXPECT_GE(counts["write"], static_cast<int>(2 * frames) + 2);
  EXPECT_GE(counts["open"], static_cast<int>(frames) + 3);
  EXPECT_GE(counts["close"], static_cast<int>(frames) + 3);
  EXPECT_EQ(tally(half_calls())["truncate"], 1 + counts["truncate"]);
}

/// One call of each name on each kind of file, in one way after another.
TEST_F(Faults, OfSomeCallsLoseNothing) {
  std::map<std::string, std::vector<int>> by_name;
  for (std::size_t i{0}; i < calls().size(); ++i) {
    const std::string name{calls()[i].substr(0, calls()[i].find(' '))};
    by_name[name + fs::path{calls()[i]}.extension().string()].push_back(static_cast<int>(i) + 1);
  }
  std::size_t turn{0};
  for (const auto& [name, numbers] : by_name) {
    const int call{numbers[numbers.size() / 2]};
    std::string kind;
    do kind = kinds[turn++ % std::size(kinds)];
    while (!makes_sense(calls()[static_cast<std::size_t>(call) - 1], kind));
    try_fault({call, kind});
  }
}

TEST_F(Faults, AFileSystemWithoutLocksIsAWarning) {
  const fs::path out{path("no_locks")};
  const Outcome outcome{run_tool(command(out), "STEREOGRID_FAULTS_FLOCK=ENOLCK " + environment(out, {0, "EIO"}))};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("this file system cannot lock"));
  expect_equal_runs(whole(), out);
}

TEST_F(Faults, AnInputThatHangsEndsTheRunAndItGoesOnLater) {
  const fs::path drive{path("drive")};
  run_well({"simulate", "scene:street?frames=8&width=160&height=96", "--out", drive});
  const auto words = [&](const char* out) {
    return Words{"run", drive, "--out", path(out).string(), "--resume", "--input-wait", "1"};
  };
  run_well(words("in_one_go"));
  EXPECT_THAT(errors_of(75, words("hung"),
                        "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) +
                            " STEREOGRID_FAULTS_HANG=" + quoted(drive / "left" / "000005.png")),
              HasSubstr("frame 5 has not come within 1 s"));
  EXPECT_EQ(lines_of(path("hung")).size(), 5U);
  EXPECT_EQ(json_of(path("hung") / "run.json")["frames"]["done"], 5);
  run_well(words("hung"));
  expect_equal_runs(path("in_one_go"), path("hung"));
}

TEST_F(Faults, AStopDoesNotWaitForAnInputThatHangs) {
  const fs::path drive{path("drive_that_hangs")};
  run_well({"simulate", "scene:street?frames=8&width=160&height=96", "--out", drive, "--no-truth"});
  for (const std::size_t done : {1U, 3U, 5U}) {  // the frame that hangs is the next one, or one of those read ahead
    const fs::path out{path("stopped" + std::to_string(done))};
    Process process{
        "env",
        {"LD_PRELOAD=" STEREOGRID_FAULTS_LIBRARY, "STEREOGRID_FAULTS_HANG=" + (drive / "left" / "000005.png").string(),
         STEREOGRID_TOOL, "run", drive, "--out", out}};
    wait_for_frames(out, done);
    process.send(SIGTERM);
    EXPECT_EQ(process.wait(), 75);
    EXPECT_EQ(json_of(out / "run.json")["frames"]["done"], lines_of(out).size());
  }
}

/// Kills runs at moments that the clock decides, until one gets to its end.
void expect_to_survive_kills(const fs::path& whole, const fs::path& folder, int kills, unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_int_distribution<int> pause_ms{1, 600};
  int run{0};
  for (int killed{0}; killed < kills; ++run) {
    const fs::path out{folder / ("killed" + std::to_string(run))};
    for (int code{-1}; code != 0 && killed < kills;) {
      Process process{command(out)};
      std::this_thread::sleep_for(std::chrono::milliseconds{pause_ms(random)});
      process.send(SIGKILL);
      code = process.wait();
      ASSERT_THAT(code, ::testing::AnyOf(0, 128 + SIGKILL));
      if (code != 0) ++killed;
    }
    run_well(command(out));
    expect_equal_runs(whole, out);
    fs::remove_all(out);
  }
}

TEST_F(Faults, KillsAtAnyMomentLoseNothing) {
  expect_to_survive_kills(whole(), path(""), 10, 1);
}

class EveryFault : public Faults {
 protected:
  /// Tries every call, or every fourth one: the quarter STEREOGRID_QUARTER, 0 to 3.
  static void try_every_fault(bool half) {
    const std::vector<std::string>& all{half ? half_calls() : calls()};
    const char* const quarter{std::getenv("STEREOGRID_QUARTER")};
    int tried{0};
    for (std::size_t i{0}; i < all.size(); ++i) {
      if (quarter != nullptr && i % 4 != std::stoul(quarter)) continue;
      for (const char* kind : kinds) {
        if (!makes_sense(all[i], kind)) continue;
        try_fault({static_cast<int>(i) + 1, kind}, half);
        ++tried;
      }
    }
    std::cout << tried << " faults in " << all.size() << " calls\n";
    EXPECT_GT(tried, 0);
  }
};

TEST_F(EveryFault, OfARunLosesNothing) {
  try_every_fault(false);
}

TEST_F(EveryFault, OfARunThatGoesOnLosesNothing) {
  try_every_fault(true);
}

TEST_F(EveryFault, AndAHundredKillsLoseNothing) {
  expect_to_survive_kills(whole(), path(""), 100, 2);
}

// Threads that the system does not give are a reason to try again, not a bug: the first one fails, then the second, …
void expect_try_again(const Words& command, const fs::path& out) {
  int failing{1};
  for (;; ++failing) {
    SCOPED_TRACE(command[0] + ", thread " + std::to_string(failing));
    fs::remove_all(out);
    const Outcome outcome{run_tool(command, "LD_PRELOAD=" + quoted(STEREOGRID_FAULTS_LIBRARY) +
                                                " STEREOGRID_FAULTS_THREAD=" + std::to_string(failing))};
    if (outcome.exit_code == 0) break;
    ASSERT_EQ(outcome.exit_code, 75) << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr("thread cannot be started"));
    EXPECT_THAT(outcome.errors, HasSubstr("ulimit -u"));
    EXPECT_THAT(outcome.errors, Not(HasSubstr("internal error")));
    ASSERT_LT(failing, 100);
  }
  EXPECT_GT(failing, 1);
}

TEST(Threads, ThatCannotBeStartedAreAReasonToTryAgain) {
  const TemporaryFolder folder;
  const fs::path out{folder.path() / "out"};
  const std::string scene{"scene:street?frames=3&width=160&height=96"};
  expect_try_again({"simulate", scene, "--out", out, "--quiet"}, out);
  expect_try_again({"run", scene, "--out", out, "--quiet", "--pictures"}, out);
  const fs::path drive{folder.path() / "drive"};
  run_well({"simulate", scene, "--out", drive, "--quiet"});
  expect_try_again({"run", drive, "--out", out, "--quiet"}, out);
  expect_try_again({"run", drive, "--out", out, "--quiet", "--poses", "odometry"}, out);
}

}  // namespace

}  // namespace stereogrid::app::testing
