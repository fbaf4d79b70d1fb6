// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Several processes with one output folder.
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> command(const fs::path& out, const std::string& frames, const std::string& more = "--resume") {
  return {"run", small_scene("street", "&frames=400"), "--out", out.string(), "--frames", frames, more};
}

/// Waits for a finished frame: the process that `writes` is in the midst of its run.
void wait_for_a_frame(const fs::path& run) {
  const auto deadline{std::chrono::steady_clock::now() + std::chrono::seconds{60}};
  while (text_of(run / "frames.jsonl").empty() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
  ASSERT_NE(text_of(run / "frames.jsonl"), "");
}

TEST(Lock, KeepsASecondRunOut) {
  const TemporaryFolder folder;
  const fs::path out{folder / "run"};
  const Process first{command(out, ":")};
  wait_for_a_frame(out);
  for (const char* flag : {"--resume", "--quiet"}) {
    EXPECT_THAT(errors_of(75, command(out, ":", flag)),
                AllOf(HasSubstr("another stereogrid is writing to " + out.string()),
                      HasSubstr("(process " + std::to_string(first.id()) + ")")));
  }
}

TEST(Lock, OfAKilledRunIsInNobodysWay) {
  const TemporaryFolder folder;
  const fs::path out{folder / "run"};
  Process first{command(out, ":")};
  wait_for_a_frame(out);
  first.send(SIGKILL);
  EXPECT_EQ(first.wait(), 128 + SIGKILL);
  const std::size_t frames{std::min(lines_of(out).size() + 1, std::size_t{399})};
  run_well(command(out, ":" + std::to_string(frames)));
  EXPECT_EQ(lines_of(out).size(), frames + 1);
  EXPECT_THAT(files_in(out), Not(Contains(".lock")));
}

TEST(Lock, OfManyThatStartTogetherOneWrites) {
  const TemporaryFolder folder;
  run_well(command(folder / "alone", ":5"));
  for (const char* flag : {"--resume", "--quiet"}) {
    const fs::path out{folder / (std::string{"run"} + flag)};
    std::vector<Process> processes;
    for (int i{0}; i < 4; ++i) processes.emplace_back(command(out, ":5", flag));
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
