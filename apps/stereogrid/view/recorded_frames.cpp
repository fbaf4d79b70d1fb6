// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/bag.hpp"
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

  void send(std::size_t frame, messages::Sink& sink) override;

 private:
  void add_channels(messages::Sink& sink);

  std::unique_ptr<mcap::Bag> bag_;
  std::vector<std::uint64_t> stamps_ns_;
  std::vector<std::optional<std::uint32_t>> channels_;  // by topic of the bag; none: of another encoding
};

RecordedFrames::RecordedFrames(const fs::path& file)
    : bag_{mcap::open_bag(file)}, stamps_ns_{grid_stamps(*bag_, io::printable_path(file))} {}

void RecordedFrames::add_channels(messages::Sink& sink) {
  for (const mcap::Topic& topic : bag_->topics()) {
    auto& channel{channels_.emplace_back()};
    if (topic.message_encoding != "cdr" || topic.schema_encoding != "ros2msg") continue;
    channel = sink.add({.topic = topic.name, .type = topic.type, .definition = topic.schema, .latched = true});
  }
}

void RecordedFrames::send(std::size_t frame, messages::Sink& sink) {
  if (channels_.empty()) add_channels(sink);
  const std::uint64_t first_ns{frame == 0 ? 0 : stamps_ns_.at(frame - 1) + 1};
  const auto messages{bag_->messages({.first_ns = first_ns, .last_ns = stamps_ns_.at(frame)})};
  while (const mcap::Message * message{messages->next()}) {
    const auto channel{channels_.at(message->channel)};
    if (channel) sink.send(*channel, static_cast<std::int64_t>(message->log_time_ns), message->data);
  }
}

}  // namespace

std::unique_ptr<PlayedFrames> played_frames(const fs::path& path) {
  const std::optional<fs::path> file{recording_at(path)};
  if (!file) return stored_frames(path);
  return std::make_unique<RecordedFrames>(*file);
}

std::string recording_name(const fs::path& path) {
  return io::printable_path(path.has_filename() ? path.filename() : path.parent_path().filename());
}

}  // namespace stereogrid::app
