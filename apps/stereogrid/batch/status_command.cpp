// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "batch/status.hpp"
#include "batch/subcommands.hpp"
#include "batch/watch.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "stereogrid/io/json_text.hpp"

namespace stereogrid::app::batch {
namespace {

struct Options {
  std::string plan;
  bool json{false};
  bool print_missing{false};
  std::string watch;
};

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
  row("poison", status.poison);
  row("given up", status.failed - status.poison);
  tell("{} of {} frames", status.frames_done, status.frames);
  if (status.frames_skipped > 0) tell(", {} skipped (run.json of the results has the reasons)", status.frames_skipped);
  if (status.frames_per_second > 0) tell(", {:.2f} frames per second and runner", status.frames_per_second);
  if (status.seconds_left > 0) tell(", about {} left", duration_text(status.seconds_left));
  tell("\n");
  for (const Failure& failure : status.failures) {
    tell("shard {} (exit code {}, {}): {}\n", failure.shard, failure.exit_code, failure.host, failure.message);
  }
}

int show_status(const Options& options) {
  const PlanReader plan{options.plan};
  if (!options.watch.empty()) {
    watch(plan, options.watch);
    return exit_done;
  }
  const Status status{status_of(plan)};
  if (options.json) {
    tell("{}\n", io::json_text(to_json(status), 1));
  } else if (options.print_missing) {
    tell("{}\n", status.to_do.text());
  } else {
    print_table(status);
  }
  return exit_done;
}

}  // namespace

void add_status_command(CLI::App& batch, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand("status", "What of a plan is done, running, missing and impossible.")};
  add_plan_argument(*command, options->plan);
  CLI::Option* const json{command->add_flag("--json", options->json, "As JSON.")};
  command
      ->add_flag(
          "--print-missing", options->print_missing,
          "Only the numbers of shards that nobody works on and that can be done, for --shard and sbatch --array: "
          "3-7,12.")
      ->excludes(json);
  command
      ->add_option("--watch", options->watch,
                   "Serve it as a page for the browser, which looks again every few seconds; Ctrl-C ends it. 0: any "
                   "free port. On other than a loopback address the page's link has a token.")
      ->type_name("PORT|ADDRESS:PORT")
      ->excludes(json)
      ->excludes(command->get_option("--print-missing"));
  command->callback([options, &exit_code] { exit_code = show_status(*options); });
}

}  // namespace stereogrid::app::batch
