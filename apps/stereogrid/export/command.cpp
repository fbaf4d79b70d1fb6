// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/option_checks.hpp"
#include "cli/progress.hpp"
#include "export/tables.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/nav2_map.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/laser_scan.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string run;
  std::string nav2_map;
  std::string laser_scan;
  std::string csv;
  std::optional<std::uint64_t> frame;
};

/// A file that is to be written.
struct Output {
  fs::path path;
  std::string text;
};

fs::path map_of(const Options& options) {
  return fs::path{options.nav2_map} / "map.yaml";
}

void refuse_to_replace(const char* option, const fs::path& file) {
  if (!io::is_file(file) && !io::is_folder(file)) return;
  throw ConfigError{
      fmt::format("{}: {} is there already. Give another name, or delete it.", option, io::printable_path(file))};
}

void check(const Options& options) {
  if (options.nav2_map.empty() && options.laser_scan.empty() && options.csv.empty()) {
    throw ConfigError{
        "export needs to know what to write: one or more of --nav2-map DIR, --laserscan FILE.csv and --csv DIR."};
  }
  if (options.frame && options.nav2_map.empty() && options.csv.empty()) {
    throw ConfigError{"--frame chooses the grid of --nav2-map and --csv, but neither is given; --laserscan has all."};
  }
  if (!options.nav2_map.empty()) {
    refuse_to_replace("--nav2-map", map_of(options));
    refuse_to_replace("--nav2-map", map_of(options).replace_extension(".pgm"));
  }
  if (!options.laser_scan.empty()) refuse_to_replace("--laserscan", options.laser_scan);
  for (const char* const name : {"frames.csv", "obstacles.csv", "grid.csv"}) {
    if (!options.csv.empty()) refuse_to_replace("--csv", fs::path{options.csv} / name);
  }
}

const io::RunFrame& chosen_frame(const io::RunReader& run, const Options& options) {
  const std::vector<io::RunFrame>& frames{run.frames()};
  if (!options.frame) return frames.back();
  const auto found{std::ranges::find(frames, *options.frame, &io::RunFrame::index)};
  if (found != frames.end()) return *found;
  throw ConfigError{fmt::format("--frame {}: the run has no such frame. Its frames are {} to {}{}.", *options.frame,
                                frames.front().index, frames.back().index,
                                frames.back().index - frames.front().index + 1 == frames.size()
                                    ? ""
                                    : ", without those that were skipped (run.json)")};
}

/// Tables with a line for each frame.
std::vector<Output> tables_of_all_frames(const io::RunReader& run, const Options& options) {
  Output frames{fs::path{options.csv} / "frames.csv", frame_header()};
  Output obstacles{fs::path{options.csv} / "obstacles.csv", obstacle_header()};
  Output scans{options.laser_scan, ""};
  messages::sensor_msgs::LaserScan scan;
  Progress progress{"frames", run.frames().size()};
  std::size_t done{0};
  for (const io::RunFrame& frame : run.frames()) {
    progress.update(done++);
    frames.text += frame_row(frame);
    obstacles.text += obstacle_rows(frame);
    if (options.laser_scan.empty()) continue;
    messages::fill(scan, run.rig_of(frame), run.grid(), run.occupancy(frame.name).view());
    if (scans.text.empty()) scans.text = scan_header(scan);
    scans.text += scan_row(frame, scan);
  }
  std::vector<Output> outputs;
  if (!options.csv.empty()) outputs = {std::move(frames), std::move(obstacles)};
  if (!options.laser_scan.empty()) outputs.push_back(std::move(scans));
  return outputs;
}

void make_folder_of(const fs::path& file) {
  if (file.has_parent_path()) io::create_folder(file.parent_path());
}

/// All is read before anything is written.
int export_run(const Options& options) {
  check(options);
  const io::RunReader run{options.run};
  const io::RunFrame& frame{chosen_frame(run, options)};
  std::vector<Output> outputs{tables_of_all_frames(run, options)};
  if (!options.csv.empty()) {
    outputs.push_back({fs::path{options.csv} / "grid.csv", grid_table(run.grid(), run.grids(frame.name))});
  }
  std::optional<io::RunWorldGrid> map;
  if (!options.nav2_map.empty()) map = run.world_grid(frame.name);
  for (const Output& output : outputs) {
    make_folder_of(output.path);
    io::write_file(output.path, output.text);
    spdlog::info("{}", io::printable_path(output.path));
  }
  if (map) {
    make_folder_of(map_of(options));
    io::write_nav2_map(map_of(options), map->geometry, map->occupancy.view());
    spdlog::info("{}: frame {}", io::printable_path(map_of(options)), frame.index);
  }
  return exit_done;
}

}  // namespace

void add_export_command(CLI::App& tool, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{tool.add_subcommand("export", "Convert a run to maps, scans and tables (docs/format.md).")};
  command->add_option("RUN_DIR", options->run, "Folder of `stereogrid run --out`.")->type_name(" ")->required();
  command
      ->add_option("--nav2-map", options->nav2_map,
                   "Write map.yaml and map.pgm for Nav2's map_server: the filtered grid of a frame.")
      ->type_name("DIR");
  command
      ->add_option(
          "--laserscan", options->laser_scan,
          "Write the nearest obstacle of each bearing, a line per frame, with the values of sensor_msgs/LaserScan.")
      ->type_name("FILE.csv");
  command
      ->add_option("--csv", options->csv,
                   "Write frames.csv (pose, status, times), obstacles.csv (of each frame) and grid.csv (the "
                   "cells of a frame).")
      ->type_name("DIR");
  command
      ->add_option("--frame", options->frame,
                   "Index of the frame in frames.jsonl, for one-frame outputs. Default: the last one.")
      ->type_name("N")
      ->check(whole_number(0, io::largest_index), "[0 - 1000000000]");
  command->callback([options, &exit_code] { exit_code = export_run(*options); });
}

}  // namespace stereogrid::app
