// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Standard streams that are closed, full, or whose reader has gone.
#include <signal.h>

#include "process.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string tool{quoted(STEREOGRID_TOOL)};
constexpr const char* full{"/dev/full"};

/// A run that warns of a frame, with these redirections. Gives its folder.
int run_with_a_warning(const TemporaryFolder& folder, const fs::path& out, const std::string& redirections) {
  const fs::path drive{folder / "drive"};
  if (!fs::exists(drive)) {
    run_well({"simulate", small_scene("street", "&frames=4"), "--out", drive.string()});
    fs::resize_file(drive / "left" / "000002.png", 100);
  }
  return shell(tool + " run " + quoted(drive.string()) + " --out " + quoted(out.string()) + " " + redirections);
}

TEST(Streams, ThatAreClosedAreNotMistakenForFilesOfTheRun) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_with_a_warning(folder, folder / "open", ">/dev/null 2>&1"), 0);
  for (const std::string closed : {"2>&-", ">&-", "<&-", "<&- >&- 2>&-", "2>&- >/dev/null"}) {
    const fs::path out{folder / closed};
    EXPECT_EQ(run_with_a_warning(folder, out, closed + (closed.find("2>") == closed.npos ? " 2>/dev/null" : "")), 0);
    expect_equal_runs(folder / "open", out);
    EXPECT_THAT(text_of(out / "run.json"), StartsWith("{"));
  }
}

TEST(Streams, ErrorsThatNobodyCanReadKeepTheirExitCode) {
  const TemporaryFolder folder;
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

TEST(Streams, AFullOutputIsAFailure) {
  const TemporaryFolder folder;
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

TEST(Streams, AFullOutputHidesNoOtherFailure) {
  EXPECT_EQ(with_full_output("fly").exit_code, 64);
  EXPECT_EQ(with_full_output("info /nowhere").exit_code, 65);
}

TEST(Streams, AReaderThatHasEnoughEndsTheProgramQuietly) {
  const TemporaryFolder folder;
  const fs::path errors{folder / "errors"};
  const fs::path code{folder / "code"};
  signal(SIGPIPE, SIG_DFL);  // independent of the test's environment
  // true reads nothing; the shell returns 141
  shell("{ sleep 0.2; " + tool + " config --markdown; echo $? >" + quoted(code.string()) + "; } 2>" +
        quoted(errors.string()) + " | true");
  EXPECT_EQ(text_of(code), "141\n");
  EXPECT_EQ(text_of(errors), "");
}

}  // namespace
}  // namespace stereogrid::app::testing
