// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>

#include "commands.hpp"
#include "compare/compare.hpp"
#include "option_checks.hpp"

namespace stereogrid::app {

void add_compare_command(CLI::App& tool, int& exit_code) {
  auto options{std::make_shared<CompareOptions>()};
  CLI::App* command{
      tool.add_subcommand("compare", "Score this library beside other methods, all on the same disparities.")};
  add_input_options(*command, options->input);
  add_config_options(*command, options->config);
  command->add_option("--frames", options->frames, frame_range_help)->type_name("FIRST:LAST");
  const std::map<std::string, TruthKind> kinds{{"lidar", TruthKind::lidar}, {"truth", TruthKind::exact}};
  command
      ->add_option("--truth", options->truth,
                   "Score against the input's lidar sweeps, or its exact truth; default: exact truth where there is "
                   "some.")
      ->transform(CLI::CheckedTransformer(kinds))
      ->type_name("lidar|truth");
  command
      ->add_option("--camera-height", options->camera_height_m,
                   "Camera over the road, where the search for the lidar's road starts (m).")
      ->type_name("M")
      ->capture_default_str()
      ->check(number(0.3, 5), "[0.3 - 5]");
  command->add_flag("--hold-out", options->hold_out,
                    "Every second ring of the lidar labels the cells, the others are for the lidar's own grid.");
  command->add_option("--only", options->only, "Only these methods; docs/baselines.md has their names.")
      ->type_name("NAME,...")
      ->delimiter(',');
  command
      ->add_option("--threads", options->threads, "Threads of the pipeline; 0: all cores. Results do not depend on it.")
      ->type_name("N")
      ->check(whole_number(0, 1024), "[0 - 1024]")
      ->capture_default_str();
  command->add_option("--json", options->json, "Also write every figure, with its interval, to this file.")
      ->type_name("FILE");
  command->add_option("--html", options->html, "Also write a report with plots to this file.")->type_name("FILE");
  command
      ->add_option("--pictures", options->pictures, "Also draw the grids of some frames side by side into this folder.")
      ->type_name("DIR");
  command->callback([options, &exit_code] { exit_code = compare(*options); });
}

}  // namespace stereogrid::app
