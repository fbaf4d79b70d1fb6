// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>

#include "cli/program.hpp"
#include "compare/compare.hpp"

namespace {

using namespace stereogrid::app;

void describe(CLI::App& program, int& exit_code) {
  auto options{std::make_shared<stereogrid::research::CompareOptions>()};
  program.description("Scores this library beside other methods, all on the same disparities.");
  add_input_options(program, options->input);
  add_config_options(program, options->config);
  program.add_option("--frames", options->frames, frame_range_help)->type_name("FIRST:LAST");
  const std::map<std::string, TruthKind> kinds{{"lidar", TruthKind::lidar}, {"truth", TruthKind::exact}};
  program
      .add_option("--truth", options->truth,
                  "Score against the input's lidar sweeps, or its exact truth; default: exact truth where there is "
                  "some.")
      ->transform(CLI::CheckedTransformer(kinds))
      ->type_name("lidar|truth");
  program
      .add_option(
          "--camera-height", options->camera_height_m,
          "Camera over the road, where the search for the lidar's road starts (m). Left out: the height that was "
          "found, else 1.64, as on KITTI.")
      ->type_name("M")
      ->check(number(0.3, 5), "[0.3 - 5]");
  program.add_flag(
      "--hold-out", options->hold_out,
      "Every second ring of the lidar labels the cells, the others are for the lidar's own grid and for fusion.");
  program
      .add_option("--matcher", options->matcher,
                  "Source of the disparities of all methods: this library (matching.method), or OpenCV's block or "
                  "semi-global matcher.")
      ->check(CLI::IsMember({"own", "opencv-bm", "opencv-sgbm"}))
      ->capture_default_str();
  program.add_option("--only", options->only, "Only these methods; docs/evaluation.md has their names.")
      ->type_name("NAME,...")
      ->delimiter(',');
  program
      .add_option("--threads", options->threads, "Threads of the pipeline; 0: all cores. Results do not depend on it.")
      ->type_name("N")
      ->check(whole_number(0, 1024), "[0 - 1024]")
      ->capture_default_str();
  program.add_option("--json", options->json, "Also write every figure, with its interval, to this file.")
      ->type_name("FILE");
  program
      .add_option("--pictures", options->pictures, "Also draw the grids of some frames side by side into this folder.")
      ->type_name("DIR");
  program
      .add_option("--grids", options->grids,
                  "Also write the grids of every frame into this folder, NAME.npz: an array for each method, and the "
                  "lidar's returns (sweep, N × 3 in the left camera's frame).")
      ->type_name("DIR");
  program.callback([options, &exit_code] { exit_code = compare(*options); });
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "stereogrid-compare", describe);
}
