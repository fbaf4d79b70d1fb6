// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/nav2_map.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/frame_messages.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  std::string run;
  std::string nav2_map;
  std::string laser_scan;
  std::optional<std::uint64_t> frame;
};

fs::path map_of(const ExportOptions& options) {
  return fs::path{options.nav2_map} / "map.yaml";
}

void refuse_to_replace(const char* option, const fs::path& file) {
  if (!io::is_file(file) && !io::is_folder(file)) return;
  throw ConfigError{
      fmt::format("{}: {} is there already. Give another name, or delete it.", option, io::printable_path(file))};
}

void check(const ExportOptions& options) {
  if (options.nav2_map.empty() && options.laser_scan.empty()) {
    throw ConfigError{"export has nothing to write. Give --nav2-map DIR, --laserscan FILE.csv or both."};
  }
  if (options.frame && options.nav2_map.empty()) {
    throw ConfigError{"--frame chooses the grid of --nav2-map, which is not given; --laserscan has all frames."};
  }
  if (!options.nav2_map.empty()) {
    refuse_to_replace("--nav2-map", map_of(options));
    refuse_to_replace("--nav2-map", map_of(options).replace_extension(".pgm"));
  }
  if (!options.laser_scan.empty()) refuse_to_replace("--laserscan", options.laser_scan);
}

const io::RunFrame& chosen_frame(const io::RunReader& run, const ExportOptions& options) {
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

/// A header line with a column for each beam.
std::string scan_header(std::size_t beams) {
  std::string line{"stamp_ns,angle_min,angle_max,angle_increment,range_min,range_max"};
  for (std::size_t i{0}; i < beams; ++i) line += fmt::format(",range_{}", i);
  return line + '\n';
}

/// Numbers have as many digits as bring the same number back; inf and nan are spelled so, which NumPy and pandas read.
std::string scan_row(const io::RunFrame& frame, const messages::sensor_msgs::LaserScan& scan) {
  return fmt::format("{},{},{},{},{},{},{}\n", frame.stamp_ns, scan.angle_min, scan.angle_max, scan.angle_increment,
                     scan.range_min, scan.range_max, fmt::join(scan.ranges, ","));
}

/// Comma-separated values (docs/format.md), a line for each frame.
std::string scans_of(const io::RunReader& run) {
  std::string text;
  messages::sensor_msgs::LaserScan scan;
  Progress progress{"frames", run.frames().size()};
  std::size_t done{0};
  for (const io::RunFrame& frame : run.frames()) {
    progress.update(done++);
    messages::fill(scan, run.rig_of(frame), run.grid(), run.occupancy(frame.name).view());
    if (text.empty()) text = scan_header(scan.ranges.size());
    text += scan_row(frame, scan);
  }
  return text;
}

void make_folder_of(const fs::path& file) {
  if (file.has_parent_path()) io::create_folder(file.parent_path());
}

/// All is read before anything is written.
int export_run(const ExportOptions& options) {
  check(options);
  const io::RunReader run{options.run};
  const io::RunFrame& frame{chosen_frame(run, options)};
  std::string scans;
  if (!options.laser_scan.empty()) scans = scans_of(run);
  std::optional<io::RunWorldGrid> map;
  if (!options.nav2_map.empty()) map = run.world_grid(frame.name);
  if (!options.laser_scan.empty()) {
    make_folder_of(options.laser_scan);
    io::write_file(options.laser_scan, scans);
    spdlog::info("{}", io::printable_path(options.laser_scan));
  }
  if (map) {
    make_folder_of(map_of(options));
    io::write_nav2_map(map_of(options), map->geometry, map->occupancy.view());
    spdlog::info("{}: frame {}", io::printable_path(map_of(options)), frame.index);
  }
  return exit_done;
}

}  // namespace

void add_export_command(Command tool, int& exit_code) {
  auto options{std::make_shared<ExportOptions>()};
  const Command command{tool.add_command("export", "Convert a run to maps and laser scans (docs/format.md).")};
  command.add_option("RUN_DIR", options->run, "Folder of `stereogrid run --out`.").required();
  command.group(Group::output);
  command.add_option("--nav2-map DIR", options->nav2_map,
                     "Write map.yaml and map.pgm for Nav2's map_server: the filtered grid of a frame.");
  command.add_option(
      "--laserscan FILE.csv", options->laser_scan,
      "Write the nearest obstacle of each bearing, a line per frame, with the values of sensor_msgs/LaserScan.");
  command.add_option("--frame N", options->frame, "Index of the map's frame in frames.jsonl. Default: the last one.")
      .check(whole_number(0, io::largest_index));
  command.callback([options, &exit_code] { exit_code = export_run(*options); });
}

}  // namespace stereogrid::app
