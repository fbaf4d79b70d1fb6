// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/engines.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::app::batch::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

EngineOptions options_of(Engine engine) {
  EngineOptions options;
  options.engine = engine;
  options.plan = "/plans/it's mine";
  options.tool = "/usr/bin/stereogrid";
  options.folder = options.plan + "/submit";
  options.memory_mb = 300;
  options.shards_per_task = 4;
  options.cpus = 2;
  options.image = "image:1";
  options.claim = "claim";
  return options;
}

std::string file_of(const Submission& submission, const std::string& name) {
  for (const EngineFile& file : submission.files) {
    if (file.name == name) return file.text;
  }
  return "";
}

TEST(BatchEngines, ShellWordsAreQuoted) {
  EXPECT_EQ(shell_quoted("it's $HOME"), "'it'\\''s $HOME'");
}

TEST(BatchEngines, SlurmHasWhatTheContractNeeds) {
  EngineOptions options{options_of(Engine::slurm)};
  options.gpu = true;
  options.time_limit = "01:00:00";
  const Submission submission{submission_of(options, simple_plan(), {{0, 9}})};
  const std::string script{file_of(submission, "slurm.sh")};
  for (const char* line :
       {"#SBATCH --requeue\n", "#SBATCH --cpus-per-task=2\n", "#SBATCH --mem=300M\n", "#SBATCH --gres=gpu:1\n",
        "#SBATCH --time=01:00:00\n", "#SBATCH --signal=B:TERM@60\n",
        "batch run '/plans/it'\\''s mine' --shards-per-task 4 --threads 2 &\n", "scontrol requeue"}) {
    EXPECT_THAT(script, HasSubstr(line));
  }
  EXPECT_THAT(file_of(submission_of(options_of(Engine::slurm), simple_plan(), {{0, 9}}), "slurm.sh"),
              Not(HasSubstr("gres")));
}

// no array is larger than Slurm takes, and the offsets make up for it
TEST(BatchEngines, SlurmArraysAreCutAtTheirLargest) {
  EngineOptions options{options_of(Engine::slurm)};
  options.jobs = 8;
  const Submission submission{submission_of(options, simple_plan(), {{0, 2}, {5, 5}, {998, 1001}, {3000, 3000}})};
  const std::string script{file_of(submission, "submit.sh")};
  EXPECT_THAT(script, HasSubstr("STEREOGRID_FIRST_TASK=0 sbatch --export=ALL --array=0-2,5,998-999%8 slurm.sh"));
  EXPECT_THAT(script, HasSubstr("STEREOGRID_FIRST_TASK=1000 sbatch --export=ALL --array=0-1%8 slurm.sh"));
  EXPECT_THAT(script, HasSubstr("STEREOGRID_FIRST_TASK=3000 sbatch --export=ALL --array=0%8 slurm.sh"));
}

TEST(BatchEngines, ParallelGoesOn) {
  EngineOptions options{options_of(Engine::parallel)};
  options.machines = "hosts";
  const Submission submission{submission_of(options, simple_plan(), {{1, 2}, {7, 7}})};
  EXPECT_EQ(file_of(submission, "tasks.txt"), "1\n2\n7\n");
  const std::string script{file_of(submission, "parallel.sh")};
  // a job log knows tasks by their lines: it must not be taken for other tasks
  const auto log_of{[](const std::string& text) { return text.substr(text.find("--joblog joblog-"), 24); }};
  const Submission other{submission_of(options, simple_plan(), {{1, 1}})};
  EXPECT_THAT(script, HasSubstr("--joblog joblog-"));
  EXPECT_NE(log_of(script), log_of(file_of(other, "parallel.sh")));
  EXPECT_THAT(script, HasSubstr(" --resume-failed --retries 5"));
  EXPECT_THAT(script, HasSubstr("--sshloginfile 'hosts'"));
}

TEST(BatchEngines, KubernetesJobIsIndexed) {
  const std::string job{file_of(submission_of(options_of(Engine::kubernetes), simple_plan(), {{0, 6}}), "job.yaml")};
  for (const char* line : {"completionMode: Indexed", "completions: 7", "backoffLimitPerIndex: 5", "action: FailIndex",
                           "restartPolicy: Never", "memory: 300M", "claimName: \"claim\""}) {
    EXPECT_THAT(job, HasSubstr(line));
  }
  EngineOptions options{options_of(Engine::kubernetes)};
  options.image.clear();
  EXPECT_THROW(static_cast<void>(submission_of(options, simple_plan(), {{0, 6}})), ConfigError);
}

TEST(BatchEngines, NothingToDoIsToldOf) {
  EXPECT_THROW(static_cast<void>(submission_of(options_of(Engine::local), simple_plan(), {})), ConfigError);
}

}  // namespace
}  // namespace stereogrid::app::batch::testing
