// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::server {
class Server;
}

namespace stereogrid::app {

/// Frames that `view` plays.
class PlayedFrames {
 public:
  PlayedFrames() = default;
  PlayedFrames(const PlayedFrames&) = delete;
  PlayedFrames& operator=(const PlayedFrames&) = delete;
  virtual ~PlayedFrames() = default;

  /// In ascending order.
  [[nodiscard]] virtual const std::vector<std::uint64_t>& stamps_ns() const = 0;
  /// Faults of the files, a text each.
  [[nodiscard]] virtual std::vector<std::string> damage() const { return {}; }
  /// Sends the messages of a frame. All topics are latched: who comes while the player stands still is shown the frame
  /// that it stands at. Throws InputError.
  virtual void send(std::size_t frame, server::Server& server) = 0;
};

/// The files of a frame as the result that wrote them. Arrays that the run has not written are unknown: a missing world
/// grid is sampled from the vehicle grid. Stages, warnings and ground are empty. Throws InputError: without occupancy.
[[nodiscard]] FrameResult stored_result(const io::RunReader& run, const io::RunFrame& frame);

/// Frames of a run's folder, with left images while its input is where it was. Throws InputError.
[[nodiscard]] std::unique_ptr<PlayedFrames> stored_frames(const std::filesystem::path& folder);

}  // namespace stereogrid::app
