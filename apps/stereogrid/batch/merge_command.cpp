// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>

#include "batch/merge.hpp"
#include "batch/subcommands.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {

void add_merge_command(CLI::App& batch, int& exit_code) {
  struct Options {
    std::string plan;
    std::string out;
    MergeOptions merge;
  };
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand(
      "merge", "Put all results together: checked, in the plan's order, the same bytes whoever made them.")};
  add_plan_argument(*command, options->plan);
  command->add_option("--out,-o", options->out, "Folder for what is merged.")->type_name("DIR")->required();
  command->add_flag("--allow-missing", options->merge.allow_missing, "Merge what there is.");
  command->add_flag("--runs", options->merge.runs,
                    "Also a folder for every drive as `stereogrid run` leaves it, its grids linked where that can be "
                    "done.");
  command->callback([options, &exit_code] {
    const PlanReader plan{options->plan};
    options->merge.out = options->out;
    const MergedFrames frames{merge(plan, options->merge)};
    tell("{} of {} frames merged into {}\n", frames.merged, frames.planned, io::printable_path(options->out));
    exit_code = exit_done;
  });
}

}  // namespace stereogrid::app::batch
