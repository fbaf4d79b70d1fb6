// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "connect/page.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/nav2_map.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "view/playback.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  std::string run;
  std::vector<std::string> beside;
  std::string nav2_map;
  std::string laser_scan;
  std::string web;
  std::optional<std::uint64_t> frame;
};

fs::path page_of(const ExportOptions& options) {
  return fs::path{options.web} / "index.html";
}

fs::path map_of(const ExportOptions& options) {
  return fs::path{options.nav2_map} / "map.yaml";
}

void refuse_to_replace(const char* option, const fs::path& file) {
  if (!io::is_file(file) && !io::is_folder(file)) return;
  throw ConfigError{
      fmt::format("{}: {} is there already. Give another name, or delete it.", option, io::printable_path(file))};
}

void check(const ExportOptions& options) {
  if (options.nav2_map.empty() && options.laser_scan.empty() && options.web.empty()) {
    throw ConfigError{"export has nothing to write. Give --web DIR, --nav2-map DIR or --laserscan FILE.csv."};
  }
  if (options.frame && options.nav2_map.empty()) {
    throw ConfigError{"--frame chooses the grid of --nav2-map, which is not given; the others have all frames."};
  }
  if (!options.nav2_map.empty()) {
    refuse_to_replace("--nav2-map", map_of(options));
    refuse_to_replace("--nav2-map", map_of(options).replace_extension(".pgm"));
  }
  if (!options.laser_scan.empty()) refuse_to_replace("--laserscan", options.laser_scan);
  if (!options.web.empty()) refuse_to_replace("--web", page_of(options));
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
    messages::fill(scan, run.rigs_of(frame), run.grid(), run.occupancy(frame.name).view());
    if (text.empty()) text = scan_header(scan.ranges.size());
    text += scan_row(frame, scan);
  }
  return text;
}

/// Collects the messages that the viewer's page shows.
class PageSink final : public messages::Sink {
 public:
  std::uint32_t add(const messages::Channel& channel) override {
    const auto found{std::ranges::find_if(channels_, [&](const auto& one) { return one["topic"] == channel.topic; })};
    if (found != channels_.end()) return static_cast<std::uint32_t>(found - channels_.begin());
    channels_.push_back({{"topic", channel.topic}, {"type", channel.type}, {"definition", channel.definition}});
    return static_cast<std::uint32_t>(channels_.size() - 1);
  }
  [[nodiscard]] bool wants(std::uint32_t channel) const override {
    static constexpr std::array shown{"/occupancy_grid",
                                      "/observed_grid",
                                      "/packed_grid",
                                      "/obstacles",
                                      "/odometry",
                                      "/obstacle_markers",
                                      "/status",
                                      "/left/image_annotated/compressed",
                                      "/u_disparity/compressed",
                                      "/left/camera_info",
                                      "/tf_static"};
    const std::string topic(channels_.at(channel)["topic"]);
    return topic.find("/predicted_grid_") != std::string::npos ||
           std::ranges::any_of(shown, [&](std::string_view name) { return topic.ends_with(name); });
  }
  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    if (!wants(channel)) return;
    const std::array<std::uint32_t, 2> header{channel, static_cast<std::uint32_t>(cdr.size())};
    frame_.append(reinterpret_cast<const char*>(header.data()), sizeof header);
    frame_.append(reinterpret_cast<const char*>(cdr.data()), cdr.size());
  }

  [[nodiscard]] const nlohmann::ordered_json& channels() const { return channels_; }
  /// The messages since begin_frame(), compressed.
  [[nodiscard]] std::string packed_frame() const { return io::deflate(frame_, io::DeflateForm::raw); }
  void begin_frame() { frame_.clear(); }

 private:
  nlohmann::ordered_json channels_ = nlohmann::ordered_json::array();
  std::string frame_;
};

nlohmann::ordered_json page_data(const std::vector<std::string>& runs) {
  const auto frames{played_frames(runs)};
  const std::vector<std::uint64_t>& stamps_ns{frames->stamps_ns()};
  PageSink sink;
  nlohmann::ordered_json data{{"name", recording_names(runs)}};
  Progress progress{"frames", stamps_ns.size()};
  for (std::size_t i{0}; i < stamps_ns.size(); ++i) {
    progress.update(i);
    sink.begin_frame();
    frames->send(i, sink);
    data["stamps"].push_back(static_cast<double>(stamps_ns[i]) * 1e-9);
    data["frames"].push_back(io::base64(sink.packed_frame()));
  }
  data["channels"] = sink.channels();
  return data;
}

/// The viewer's page with the frames in it: one file, without a server. Modules of a file have no addresses, so they
/// get some.
std::string page_with(const nlohmann::ordered_json& data) {
  std::string page;
  std::string style;
  nlohmann::ordered_json modules;
  for (const server::Asset& asset : viewer_assets()) {
    if (asset.path == "/") page = asset.bytes;
    if (asset.path.ends_with(".css")) {
      replace_all(page, "<link rel=\"stylesheet\" href=\"" + asset.path.substr(1) + "\">\n", "");
      style += asset.bytes;
    }
    if (asset.path.ends_with(".js")) modules[asset.path.substr(1)] = asset.bytes;
  }
  replace_all(page, "</head>", "<style>\n" + style + "</style>\n</head>");
  replace_all(page, "<script type=\"module\" src=\"main.js\"></script>\n", "");
  replace_all(page, "</body>",
              fmt::format(R"(<script type="application/json" id="modules">{}</script>
<script type="application/json" id="recording">{}</script>
<script>
const modules = JSON.parse(document.getElementById('modules').textContent);
const addresses = {{}};
const addressOf = (name) => addresses[name] ??= URL.createObjectURL(new Blob(
  [modules[name].replace(/from '\.\/([a-z_]+\.js)'/g, (_, other) => `from '${{addressOf(other)}}'`)], {{ type: 'text/javascript' }}));
import(addressOf('main.js'));
</script>
</body>)",
                          embedded_json(io::json_text(modules)), embedded_json(io::json_text(data))));
  return page;
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
  std::string page;
  if (!options.web.empty()) {
    std::vector<std::string> runs{options.run};
    runs.insert(runs.end(), options.beside.begin(), options.beside.end());
    page = page_with(page_data(runs));
  }
  if (!page.empty()) {
    make_folder_of(page_of(options));
    io::write_file(page_of(options), page);
    spdlog::info("{}: {} frames, {:.1f} MB; opens in a browser, from disk or from any web server",
                 io::printable_path(page_of(options)), run.frames().size(), static_cast<double>(page.size()) * 1e-6);
  }
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
  const Command command{
      tool.add_command("export", "Convert a run to a web page, maps and laser scans (docs/format.md).")};
  command.add_option("RUN_DIR", options->run, "Folder of `stereogrid run --out`.").required();
  command.group(Group::output);
  command.add_option("--web DIR", options->web,
                     "Write index.html: the viewer with all frames in it, to be opened from disk or put on any web "
                     "server.");
  command.add_option("--beside RUN,RUN,...", options->beside,
                     "Further runs that the page of --web shows beside this one, as 'view' does.");
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
