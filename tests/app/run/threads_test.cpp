// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Threads that the system does not give (faults/faults.cpp): a reason to try again, not a bug.
#include "process.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Lets the first thread fail, then the second one, until there are enough.
void expect_try_again(const std::vector<std::string>& command, const fs::path& out) {
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
  expect_try_again({"simulate", scene, "--out", out.string(), "--quiet"}, out);
  expect_try_again({"run", scene, "--out", out.string(), "--quiet", "--pictures"}, out);
  const fs::path drive{folder.path() / "drive"};
  run_well({"simulate", scene, "--out", drive.string(), "--quiet"});
  expect_try_again({"run", drive.string(), "--out", out.string(), "--quiet"}, out);
  expect_try_again({"run", drive.string(), "--out", out.string(), "--quiet", "--poses", "odometry"}, out);
}

}  // namespace
}  // namespace stereogrid::app::testing
