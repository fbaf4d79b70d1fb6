// SPDX-License-Identifier: Apache-2.0
#include <signal.h>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Lock = FolderTest;
using Resume = FolderTest;

Words command(const fs::path& out, const std::string& frames, const std::string& more = "") {
  Words words{"run", small_scene("street", "&frames=6"), "--out", out, "--frames", frames};
  if (!more.empty()) words.push_back(more);
  return words;
}

void append(const fs::path& path, const std::string& text) {
  std::ofstream{path, std::ios::app | std::ios::binary} << text;
}

TEST_F(Resume, DropsATornLastLine) {
  run_well(command(folder / "whole", ":"));
  run_well(command(folder / "torn", ":3"));
  append(folder / "torn" / "frames.jsonl", R"({"index":4,"name":"0000)");
  run_well(command(folder / "torn", ":", "--resume"));
  expect_equal_runs(folder / "whole", folder / "torn");
  const Json run(json_of(folder / "torn" / "run.json"));
  EXPECT_EQ(run["frames"]["done"], 6);
  EXPECT_EQ(run["frames"]["complete"], true);
}

TEST_F(Resume, OfAFinishedRunChangesNothing) {
  run_well(command(folder / "run", "0:1"));
  const std::string before{text_of(folder / "run" / "frames.jsonl")};
  run_well(command(folder / "run", "0:1", "--resume"));
  EXPECT_EQ(text_of(folder / "run" / "frames.jsonl"), before);
}

TEST_F(Resume, StartsWhereThereIsNothing) {
  run_well(command(folder / "run", "0:0", "--resume"));
  EXPECT_EQ(lines_of(folder / "run").size(), 1U);
}

TEST_F(Resume, RefusesOtherSettingsAndNamesThem) {
  run_well(command(folder / "run", "0:0"));
  const Words words{joined(command(folder / "run", "0:2", "--resume"), {"--set", "filter.decay_time_s=5"})};
  EXPECT_THAT(errors_of(64, words), HasSubstr("filter/decay_time_s: was 2"));
  EXPECT_THAT(errors_of(64, joined(words, {"--compact"})), HasSubstr("compact: was false, is true"));
  EXPECT_THAT(errors_of(64, command(folder / "run", "1:2", "--resume")), HasSubstr("first frame: was 0, is 1"));
}

TEST_F(Resume, NamesMissingGridsAndProcessesThemAgainOnDemand) {
  run_well(command(folder / "whole", "0:2"));
  run_well(command(folder / "run", "0:2"));
  fs::remove(folder / "run" / "grids" / "000001.npz");
  EXPECT_THAT(errors_of(65, command(folder / "run", "0:2", "--resume")),
              AllOf(HasSubstr("000001.npz: is missing"), HasSubstr("remove the lines")));
  const std::string lines{text_of(folder / "run" / "frames.jsonl")};
  std::ofstream{folder / "run" / "frames.jsonl"} << lines.substr(0, lines.find('\n') + 1);
  run_well(command(folder / "run", "0:2", "--resume"));
  expect_equal_runs(folder / "whole", folder / "run");
}

TEST_F(Resume, WithoutItAFolderWithARunIsRefused) {
  run_well(command(folder / "run", "0:0"));
  EXPECT_THAT(errors_of(64, command(folder / "run", "0:0")), HasSubstr("--resume"));
}

/// One sitting of a run that is done in several.
Outcome sit(const fs::path& run, const std::string& frames, const Words& more) {
  const std::string scene{"scene:street?frames=40&width=160&height=100"};
  return run_well(joined({"run", scene, "--out", run, "--frames", frames, "--resume"}, more));
}

struct Way {
  const char* name;
  Words options;
  const char* second;  ///< from where it continues the second time
};

// Continues from the last saved state, or from the first frame, with the same results. With --every 4 the states that
// are due after 6, 13, 20, 27 and 34 are saved with the next frame that is written.
TEST_F(Resume, OfALongRunGoesOnExactly) {
  const char* const last{"frame 38, from the state after frame 34"};
  const char* const last_sparse{"frame 37, from the state after frame 36"};
  for (const Way& way : {Way{"poses", {}, last}, Way{"odometry", {"--poses", "odometry"}, last},
                         Way{"sparse poses", {"--every", "4"}, last_sparse},
                         Way{"sparse odometry", {"--every", "4", "--poses", "odometry"}, last_sparse}}) {
    SCOPED_TRACE(way.name);
    const auto options = [&](const char* every) { return joined(way.options, {"--checkpoint-every", every}); };
    const fs::path whole{folder / way.name / "whole"};
    const fs::path saved{folder / way.name / "saved"};
    const fs::path unsaved{folder / way.name / "unsaved"};
    sit(whole, ":", options("100"));
    sit(saved, ":24", options("7"));
    EXPECT_THAT(sit(saved, ":37", options("7")).errors, HasSubstr("frame 25, from the state after frame 20"));
    EXPECT_THAT(sit(saved, ":", options("7")).errors, HasSubstr(way.second));
    expect_equal_runs(whole, saved);
    sit(unsaved, ":36", options("0"));
    EXPECT_THAT(sit(unsaved, ":", options("0")).errors, HasSubstr("processing from frame 0 again"));
    expect_equal_runs(whole, unsaved);
  }
}

TEST_F(Resume, ADamagedSavedStateIsReportedAndDoneWithout) {
  sit(folder / "whole", ":14", {"--checkpoint-every", "5"});
  for (const std::size_t kept : {std::size_t{0}, std::size_t{1000}}) {
    const fs::path run{folder / ("cut to " + std::to_string(kept))};
    sit(run, ":11", {"--checkpoint-every", "5"});
    fs::resize_file(run / "state.npz", kept);
    EXPECT_THAT(sit(run, ":14", {"--checkpoint-every", "5"}).errors, HasSubstr("state.npz"));
    expect_equal_runs(folder / "whole", run);
  }
}

std::vector<std::string> lock_command(const fs::path& out, const std::string& frames,
                                      const std::string& more = "--resume") {
  return {"run", small_scene("street", "&frames=400"), "--out", out, "--frames", frames, more};
}

TEST_F(Lock, KeepsASecondRunOut) {
  const fs::path out{folder / "run"};
  const Process first{lock_command(out, ":")};
  wait_for_frames(out, 1);
  for (const char* flag : {"--resume", "--quiet"}) {
    EXPECT_THAT(errors_of(75, lock_command(out, ":", flag)),
                AllOf(HasSubstr("another stereogrid is writing to " + out.string()),
                      HasSubstr("(process " + std::to_string(first.id()) + ")")));
  }
}

TEST_F(Lock, OfAKilledRunIsInNobodysWay) {
  const fs::path out{folder / "run"};
  Process first{lock_command(out, ":")};
  wait_for_frames(out, 1);
  first.send(SIGKILL);
  EXPECT_EQ(first.wait(), 128 + SIGKILL);
  const std::size_t frames{std::min(lines_of(out).size() + 1, std::size_t{399})};
  run_well(lock_command(out, ":" + std::to_string(frames)));
  EXPECT_EQ(lines_of(out).size(), frames + 1);
  EXPECT_THAT(files_in(out), Not(Contains(".lock")));
}

TEST_F(Lock, OfManyThatStartTogetherOneWrites) {
  run_well(lock_command(folder / "alone", ":5"));
  for (const char* flag : {"--resume", "--quiet"}) {
    const fs::path out{folder / (std::string{"run"} + flag)};
    std::vector<Process> processes;
    for (int i{0}; i < 4; ++i) processes.emplace_back(lock_command(out, ":5", flag));
    int done{0};
    for (Process& process : processes) {
      const int code{process.wait()};
      // too late for its turn: without --resume the folder has a run by then
      EXPECT_THAT(code, ::testing::AnyOf(0, 75, 64));
      if (code == 0) ++done;
    }
    EXPECT_GE(done, 1);
    expect_equal_runs(folder / "alone", out);
  }
}

}  // namespace
}  // namespace stereogrid::app::testing
