// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "batch/subcommands.hpp"
#include "commands.hpp"

namespace stereogrid::app {

void add_batch_command(CLI::App& tool, int& exit_code) {
  CLI::App* command{tool.add_subcommand("batch", "Thousands of drives: a plan, which any scheduler works on.")};
  command->require_subcommand(1);
  command->footer("docs/fleet.md tells how it is done with Slurm, GNU parallel and Kubernetes.");
  batch::add_plan_command(*command, exit_code);
  batch::add_run_command(*command, exit_code);
  batch::add_status_command(*command, exit_code);
  batch::add_merge_command(*command, exit_code);
  batch::add_submit_command(*command, exit_code);
  for (CLI::App* one : command->get_subcommands({})) one->fallthrough();
}

void batch::add_plan_argument(CLI::App& command, std::string& plan) {
  command.add_option("PLAN", plan, "What `stereogrid batch plan --out` has left.")->type_name(" ")->required();
}

}  // namespace stereogrid::app
