// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "batch/merge.hpp"
#include "batch/runner.hpp"
#include "batch/status.hpp"
#include "batch/subcommands.hpp"
#include "cli/commands.hpp"
#include "cli/console.hpp"
#include "cli/interrupt.hpp"
#include "cli/option_checks.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app::batch {
namespace {

/// Exit code of several shards: first whether the engine should try again.
int worse(int a, int b) {
  for (const int code : {exit_try_again, exit_bug, exit_usage, exit_input}) {
    if (a == code || b == code) return code;
  }
  return exit_done;
}

int run_shards(const std::string& folder, const std::string& numbers, RunnerOptions options) {
  const PlanReader plan{folder};
  if (plan.plan().version != version()) {
    throw ConfigError{fmt::format("{}: the plan is of stereogrid {}, this is {}. Use that one, or make a new plan.",
                                  io::printable(folder), plan.plan().version, version())};
  }
  options.report = spdlog::should_log(spdlog::level::info);
  // a thousand runners would fill the log
  if (spdlog::get_level() == spdlog::level::info) spdlog::set_level(spdlog::level::warn);
  catch_interrupts();
  int code{exit_done};
  const std::uint64_t shards{plan.plan().shards};
  for (const std::uint64_t number : numbers_in(numbers.empty() ? fmt::format("0-{}", shards - 1) : numbers, shards)) {
    if (interrupted() != 0) return exit_try_again;
    code = worse(code, run_shard(plan, number, options));
  }
  return interrupted() == 0 ? code : exit_try_again;
}

void add_run_command(CLI::App& batch, int& exit_code) {
  struct Options {
    std::string plan;
    std::string shards;
    bool all{false};
    RunnerOptions runner;
  };
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand("run", "Process one shard, or several.")};
  add_plan_argument(*command, options->plan);
  CLI::Option* const shard{
      command->add_option("--shard", options->shards, "Numbers of shards, from 0.")->type_name("K | 3-7,12")};
  command->add_flag("--all", options->all, "Process all shards, one after the other.")->excludes(shard);
  command->add_option("--threads", options->runner.threads, "Threads of the pipeline; 0: all cores.")
      ->type_name("N")
      ->check(whole_number(0, 1024), "[0 - 1024]")
      ->capture_default_str();
  command->add_option("--input-wait", options->runner.input_wait_s, "Maximum time to load a frame. Exit code 75.")
      ->type_name("S")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_flag("--retry-poison", options->runner.retry_poison, "Retry shards recorded as impossible.");
  command->callback([options, &exit_code] {
    if (options->shards.empty() && !options->all) {
      throw ConfigError{"batch run needs numbers of shards. Give --shard 3-7,12, or --all."};
    }
    exit_code = run_shards(options->plan, options->shards, options->runner);
  });
}

std::string duration_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  return seconds < 7200 ? fmt::format("{:.0f} min", seconds / 60) : fmt::format("{:.1f} h", seconds / 3600);
}

void print_table(const Status& status) {
  const auto row = [&](const char* name, std::uint64_t count) {
    tell("{:<8} {:>9}  {:5.1f} %\n", name, count,
         100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::uint64_t>(status.shards, 1)));
  };
  row("done", status.done);
  row("running", status.running);
  row("stopped", status.stopped);
  row("missing", status.missing);
  row("failed", status.failed);
  tell("{} of {} frames", status.frames_done, status.frames);
  if (status.frames_skipped > 0) tell(", {} skipped (run.json of the results has the reasons)", status.frames_skipped);
  if (status.frames_per_second > 0) tell(", {:.2f} frames per second and runner", status.frames_per_second);
  if (status.seconds_left > 0) tell(", about {} left", duration_text(status.seconds_left));
  tell("\n");
  for (const Failure& failure : status.failures) {
    tell("shard {} (exit code {}, {}): {}\n", failure.shard, failure.exit_code, failure.host, failure.message);
  }
}

void add_status_command(CLI::App& batch, int& exit_code) {
  struct Options {
    std::string plan;
    bool json{false};
    bool print_missing{false};
  };
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand("status", "Count a plan's shards: done, running, missing, failed.")};
  add_plan_argument(*command, options->plan);
  CLI::Option* const json{command->add_flag("--json", options->json, "As JSON.")};
  command
      ->add_flag("--print-missing", options->print_missing,
                 "Print only the numbers of missing and stopped shards, for --shard: 3-7,12.")
      ->excludes(json);
  command->callback([options, &exit_code] {
    const Status status{status_of(PlanReader{options->plan})};
    if (options->json) {
      tell("{}\n", io::json_text(to_json(status), 1));
    } else if (options->print_missing) {
      tell("{}\n", text_of(status.to_do));
    } else {
      print_table(status);
    }
    exit_code = exit_done;
  });
}

void add_merge_command(CLI::App& batch, int& exit_code) {
  struct Options {
    std::string plan;
    std::string out;
    MergeOptions merge;
  };
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand("merge", "Check all results and merge them in the plan's order.")};
  add_plan_argument(*command, options->plan);
  command->add_option("--out,-o", options->out, "Folder for the merged results.")->type_name("DIR")->required();
  command->add_flag("--allow-missing", options->merge.allow_missing, "Leave out shards without a result.");
  command->add_flag("--runs", options->merge.runs,
                    "Also a folder for every drive as `stereogrid run` leaves it; grids are linked where possible.");
  command->callback([options, &exit_code] {
    const PlanReader plan{options->plan};
    options->merge.out = options->out;
    const MergedFrames frames{merge(plan, options->merge)};
    tell("{} of {} frames merged into {}\n", frames.merged, frames.planned, io::printable_path(options->out));
    exit_code = exit_done;
  });
}

}  // namespace

void add_plan_argument(CLI::App& command, std::string& plan) {
  command.add_option("PLAN", plan, "Folder that `stereogrid batch plan --out` has written.")
      ->type_name(" ")
      ->required();
}

}  // namespace stereogrid::app::batch

namespace stereogrid::app {

void add_batch_command(CLI::App& tool, int& exit_code) {
  CLI::App* command{tool.add_subcommand("batch", "Process thousands of drives by a plan, with any scheduler.")};
  command->require_subcommand(1);
  command->footer("docs/fleet.md describes it with Slurm, GNU parallel, Kubernetes and Snakemake.");
  batch::add_plan_command(*command, exit_code);
  batch::add_run_command(*command, exit_code);
  batch::add_status_command(*command, exit_code);
  batch::add_merge_command(*command, exit_code);
  batch::add_submit_command(*command, exit_code);
  for (CLI::App* one : command->get_subcommands({})) one->fallthrough();
}

}  // namespace stereogrid::app
