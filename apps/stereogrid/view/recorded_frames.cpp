// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "view/recorded_frames.hpp"

#include <algorithm>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

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

}  // namespace

fs::path recording_at(const fs::path& path) {
  if (!io::is_folder(path)) return path;
  if (io::is_there(path / "metadata.yaml")) return path;  // a rosbag2 folder
  std::vector<fs::path> found;
  for (const fs::path& entry : io::entries_of(path)) {
    if (entry.extension() == ".mcap" && io::is_file(entry)) found.push_back(entry);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) throw InputError{io::printable_path(path), "has no recording (.mcap) in it.", how_to_record};
  throw InputError{io::printable_path(path), "has several recordings (.mcap) in it.", "Name the one to be shown."};
}

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

void RecordedFrames::send(std::size_t frame, server::Server& server) const {
  const std::uint64_t first_ns{frame == 0 ? 0 : stamps_ns_.at(frame - 1) + 1};
  const auto messages{bag_->messages({.first_ns = first_ns, .last_ns = stamps_ns_.at(frame)})};
  server.send_time(stamps_ns_.at(frame));
  while (const mcap::Message * message{messages->next()}) {
    server.send(channels_.at(message->channel), message->log_time_ns, message->data);
  }
}

}  // namespace stereogrid::app
