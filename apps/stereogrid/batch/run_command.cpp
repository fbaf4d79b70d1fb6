// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "batch/array_list.hpp"
#include "batch/runner.hpp"
#include "batch/subcommands.hpp"
#include "batch/task_number.hpp"
#include "batch/transfer.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "option_checks.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app::batch {
namespace {

struct Options {
  std::string plan;
  std::string shards;
  bool all{false};
  int shards_per_task{1};
  RunnerOptions runner;
  TransferOptions transfer;
};

std::vector<NumberRange> ranges_of(const Options& options, std::uint64_t shards) {
  if (options.all) return {{0, shards - 1}};
  if (!options.shards.empty()) return parse_array_list(options.shards, shards);
  const std::uint64_t task{task_number([](const char* name) { return std::getenv(name); })};
  return {shards_of_task(task, static_cast<std::uint64_t>(options.shards_per_task), shards)};
}

/// What an engine is told of several shards: first whether it should try again.
int worse(int a, int b) {
  for (const int code : {exit_try_again, exit_bug, exit_usage, exit_input}) {
    if (a == code || b == code) return code;
  }
  return exit_done;
}

int run_shards(Options options, const CLI::App& command) {
  const PlanReader plan{options.plan};
  if (plan.plan().version != version()) {
    throw ConfigError{fmt::format("{}: the plan is of stereogrid {}, this is {}. Use that one, or make a new plan.",
                                  io::printable(options.plan), plan.plan().version, version())};
  }
  const std::vector<NumberRange> ranges{ranges_of(options, plan.plan().shards)};
  const TransferOptions transfer_options{with_given(transfer_options_of(plan), command, options.transfer)};
  check(transfer_options);
  Transfer transfer{transfer_options, [] { return interrupted() != 0; }};
  options.runner.transfer = &transfer;
  catch_interrupts();
  int code{exit_done};
  for (const NumberRange& range : ranges) {
    for (std::uint64_t number{range.first}; number <= range.last && interrupted() == 0; ++number) {
      code = worse(code, run_shard(plan, number, options.runner));
    }
  }
  return interrupted() == 0 ? code : exit_try_again;
}

}  // namespace

void add_run_command(CLI::App& batch, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand(
      "run", "Work on one shard, or a few. Which: --shard, or what Slurm, Kubernetes, AWS Batch or GNU parallel say.")};
  add_plan_argument(*command, options->plan);
  CLI::Option* const shard{command->add_option("--shard", options->shards, "Numbers from 0.")->type_name("K | 3-7,12")};
  command->add_flag("--all", options->all, "All of them, one after the other.")->excludes(shard);
  command
      ->add_option("--shards-per-task", options->shards_per_task,
                   "Task K of the engine is the shards from K times this on.")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--threads", options->runner.threads, "Threads of the pipeline; 0: all cores.")
      ->type_name("N")
      ->check(whole_number(0, 1024), "[0 - 1024]")
      ->capture_default_str();
  command
      ->add_option("--attempts", options->runner.attempts,
                   "A shard whose runners crash so often in a row, at the same frame, is given up.")
      ->type_name("N")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--input-wait", options->runner.input_wait_s,
                   "Give up where a frame takes longer than this to load. Exit code 75.")
      ->type_name("S")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_flag("--retry-poison", options->runner.retry_poison, "Try again what has been recorded as impossible.");
  add_transfer_options(*command, options->transfer);
  command->callback([options, command, &exit_code] { exit_code = run_shards(*options, *command); });
}

}  // namespace stereogrid::app::batch
