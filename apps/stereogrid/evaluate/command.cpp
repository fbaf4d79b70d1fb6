// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "connect/page.hpp"
#include "evaluate/figures.hpp"
#include "evaluate/output.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"

namespace stereogrid::app {
namespace {

std::string text_of(const std::vector<server::Asset>& assets, std::string_view path) {
  return std::ranges::find(assets, path, &server::Asset::path)->bytes;
}

/// One HTML file that needs nothing else, from json_of. Throws DeviceError.
void write_report(const std::filesystem::path& path, const nlohmann::ordered_json& evaluation) {
  nlohmann::ordered_json with_titles(evaluation);
  with_titles["figures"] = {{"motion", declarations_of(motion_figures)},
                            {"witness", declarations_of(witness_figures)},
                            {"things", declarations_of(thing_figures)},
                            {"tracking", declarations_of(tracking_figures)},
                            {"errors", declarations_of(error_figures)}};
  const std::string data{embedded_json(io::json_text(with_titles))};
  const auto viewer{viewer_assets()};
  const auto report{report_assets()};
  std::string page{text_of(report, "/page.html")};
  replace_all(page, "@THEME@", text_of(viewer, "/theme.css"));
  // one module, so that it needs no imports
  replace_all(page, "@SCRIPT@", text_of(viewer, "/plot.js") + text_of(report, "/page.js"));
  replace_all(page, "@DATA@", data);
  io::write_file(path, page);
}

Evaluation evaluate_with_progress(const EvaluateOptions& options) {
  std::optional<Progress> progress;
  return evaluate(options, [&progress](std::size_t done, std::size_t total) {
    if (!progress) progress.emplace("frames", total);
    progress->update(done);
  });
}

int evaluate_command(const EvaluateOptions& options) {
  const nlohmann::ordered_json json(json_of(evaluate_with_progress(options)));
  write_output(table_of(json));
  flush_output();  // before a file that is /dev/stdout
  if (!options.json.empty()) io::write_file(options.json, io::json_text(json, 1) + "\n");
  if (!options.html.empty()) write_report(options.html, json);
  return exit_done;
}

}  // namespace

void add_evaluate_command(Command tool, int& exit_code) {
  auto options{std::make_shared<EvaluateOptions>()};
  const Command command{tool.add_command("evaluate", "Score a run against lidar or exact truth.")};
  command.add_option("RUN_DIR", options->run, "Folder of `stereogrid run --out`.").required();
  command.add_option("INPUT", options->input, "Input of the run. Default: the path stored in the run.");
  command.group(Group::input);
  command
      .add_option("--truth", options->truth,
                  "lidar: the input's sweeps; truth: exact truth of a scene or a rendered drive. Default: exact "
                  "truth if available.")
      .one_of({"lidar", "truth"});
  command
      .add_option("--camera-height M", options->camera_height_m,
                  "Camera height (m) at which the search for the lidar's road starts. Default: the height that the "
                  "run has estimated, else 1.64, as on KITTI.")
      .check(number(0.3, 5), "0.3 … 5");
  command.group(Group::output);
  command.add_option("--json FILE", options->json, "Write every figure to this file, too.");
  command.add_option("--html FILE", options->html, "Write a report with plots to this file, too.");
  command.callback([options, &exit_code] { exit_code = evaluate_command(*options); });
}

}  // namespace stereogrid::app
