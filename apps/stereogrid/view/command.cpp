// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "connect/page.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/server/server.hpp"
#include "view/playback.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* how_to_record{"Record one with 'stereogrid run INPUT --out DIR --mcap'."};

std::vector<std::uint64_t> grid_stamps(const mcap::Bag& bag, const std::string& file) {
  const auto grids{std::ranges::find_if(bag.topics(), [](const mcap::Topic& topic) {
    return topic.name.ends_with("/occupancy_grid") && topic.type == "nav_msgs/msg/OccupancyGrid";
  })};
  std::vector<std::uint64_t> stamps;
  if (grids != bag.topics().end()) {
    const auto messages{bag.messages({.topics = {grids->name}})};
    while (const mcap::Message * message{messages->next()}) {
      if (stamps.empty() || message->log_time_ns > stamps.back()) stamps.push_back(message->log_time_ns);
    }
  }
  if (stamps.empty()) throw InputError{file, "has no grids of stereogrid in it.", how_to_record};
  return stamps;
}

/// The recording that `path` names: itself, or the only .mcap of a run's folder. None: a run without one. Throws
/// InputError.
std::optional<fs::path> recording_at(const fs::path& path) {
  if (!io::is_folder(path)) return path;
  if (io::is_there(path / "metadata.yaml")) return path;  // a rosbag2 folder
  std::vector<fs::path> found;
  for (const fs::path& entry : io::entries_of(path)) {
    if (entry.extension() == ".mcap" && io::is_file(entry)) found.push_back(entry);
  }
  if (found.size() == 1) return found.front();
  if (io::is_there(path / "run.json") || io::is_there(path / "frames.jsonl")) return std::nullopt;
  if (found.empty()) {
    throw InputError{io::printable_path(path), "neither a run nor a recording.",
                     "Give the folder of 'stereogrid run INPUT --out DIR', or an .mcap file."};
  }
  throw InputError{io::printable_path(path), "has several recordings (.mcap) in it.", "Name the one to be shown."};
}

/// A recording of stereogrid's messages, frame by frame: a frame ends with each message on the topic of the filtered
/// grid.
class RecordedFrames final : public PlayedFrames {
 public:
  /// Reads through the recording once. Throws InputError: no recording, or one without grids.
  explicit RecordedFrames(const std::filesystem::path& file);

  [[nodiscard]] const std::vector<std::uint64_t>& stamps_ns() const override { return stamps_ns_; }
  [[nodiscard]] std::vector<std::string> damage() const override { return bag_->damage(); }

  void send(std::size_t frame, server::Server& server) override;

 private:
  void add_channels(server::Server& server);

  std::unique_ptr<mcap::Bag> bag_;
  std::vector<std::uint64_t> stamps_ns_;
  std::vector<server::ChannelId> channels_;  // by topic of the bag
};

RecordedFrames::RecordedFrames(const fs::path& file)
    : bag_{mcap::open_bag(file)}, stamps_ns_{grid_stamps(*bag_, io::printable_path(file))} {}

void RecordedFrames::add_channels(server::Server& server) {
  for (const mcap::Topic& topic : bag_->topics()) {
    server::Channel channel;
    channel.topic = topic.name;
    channel.encoding = topic.message_encoding;
    channel.schema_name = topic.type;
    channel.schema = topic.schema;
    channel.schema_encoding = topic.schema_encoding;
    channel.latched = true;
    channels_.push_back(server.add_channel(std::move(channel)));
  }
}

void RecordedFrames::send(std::size_t frame, server::Server& server) {
  if (channels_.empty()) add_channels(server);
  const std::uint64_t first_ns{frame == 0 ? 0 : stamps_ns_.at(frame - 1) + 1};
  const auto messages{bag_->messages({.first_ns = first_ns, .last_ns = stamps_ns_.at(frame)})};
  server.send_time(stamps_ns_.at(frame));
  while (const mcap::Message * message{messages->next()}) {
    server.send(channels_.at(message->channel), message->log_time_ns, message->data);
  }
}

struct ViewOptions {
  std::string recording;
  PageOptions page;
};

server::ServerOptions server_options(const fs::path& file, Playback& playback) {
  server::ServerOptions made;
  made.name = io::printable_path(file.filename());
  made.sends_time = true;
  made.parameters.values = playback.parameters();
  made.parameters.set = [&playback](const server::Parameter& parameter) { return playback.set(parameter); };
  return made;
}

/// Plays until a stop is requested.
void play(PlayedFrames& frames, Playback& playback, server::Server& server) {
  using namespace std::chrono_literals;
  std::optional<PlaybackState> shown;
  while (interrupted() == 0) {
    const PlaybackState state{playback.wait(100ms)};
    if (shown == state) continue;
    if (!shown || shown->frame != state.frame) frames.send(static_cast<std::size_t>(state.frame), server);
    for (const server::Parameter& parameter : playback.parameters_of(state)) server.set_parameter(parameter);
    shown = state;
  }
}

int view(const ViewOptions& options) {
  const std::optional<fs::path> file{recording_at(options.recording)};
  const std::unique_ptr<PlayedFrames> frames{file ? std::make_unique<RecordedFrames>(*file)
                                                  : stored_frames(options.recording)};
  Playback playback{frames->stamps_ns()};
  const auto server{start_server(options.page, server_options(file.value_or(options.recording), playback))};
  catch_interrupts();
  for (const std::string& sentence : frames->damage()) log_on_stderr("warning: {}\n", sentence);
  print("{} frames; open {}\n", frames->stamps_ns().size(), server->url());
  if (!failed_output().empty()) return exit_try_again;  // run_program() says it
  play(*frames, playback, *server);
  return exit_done;
}

}  // namespace

void add_view_command(Command tool, int& exit_code) {
  auto options{std::make_shared<ViewOptions>()};
  const Command command{tool.add_command("view", "Play a run or a recording in the browser; Ctrl-C ends it.")};
  command.add_option("RUN", options->recording, "Folder of 'run --out', or a recording of 'run --mcap' (FILE.mcap).")
      .required();
  add_page_options(command, options->page);
  command.callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace stereogrid::app
