// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::app {

/// The recording that `path` names: itself, or the only .mcap of a run's folder. Throws InputError.
[[nodiscard]] std::filesystem::path recording_at(const std::filesystem::path& path);

/// A recording of stereogrid's messages, frame by frame: a frame ends with each message on the topic of the filtered
/// grid.
class RecordedFrames {
 public:
  /// Reads through the recording once. Throws InputError: no recording, or one without grids.
  explicit RecordedFrames(const std::filesystem::path& file);

  [[nodiscard]] const std::vector<std::uint64_t>& stamps_ns() const { return stamps_ns_; }
  [[nodiscard]] const mcap::Bag& bag() const { return *bag_; }

  /// Advertises the topics. All are latched: who comes while the player stands still is shown the frame that it stands
  /// at.
  void add_channels(server::Server& server);
  /// Sends the messages of a frame to the server that has the channels. Throws InputError.
  void send(std::size_t frame, server::Server& server) const;

 private:
  std::unique_ptr<mcap::Bag> bag_;
  std::vector<std::uint64_t> stamps_ns_;
  std::vector<server::ChannelId> channels_;  // by topic of the bag
};

}  // namespace stereogrid::app
