// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/messages/sink.hpp"
#include "stereogrid/result.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::app {

/// State of a player.
struct PlaybackState {
  std::int64_t frame{0};
  bool playing{false};
  double speed{1};

  bool operator==(const PlaybackState&) const = default;
};

/// Which frame is due, as time goes by and viewers want it. They read and set it as parameters:
///
///   player.playing     bool
///   player.frame       from 0
///   player.time_s      from the first frame on; set: the last frame that is not later
///   player.speed       0.05 to 20
///   player.frames      how many there are; player.duration_s: from the first to the last. Neither can be set.
///
/// Its functions may be called from any thread.
class Playback {
 public:
  explicit Playback(std::vector<std::uint64_t> stamps_ns);

  [[nodiscard]] std::vector<server::Parameter> parameters() const { return parameters_of(state()); }
  [[nodiscard]] std::vector<server::Parameter> parameters_of(const PlaybackState& state) const;
  /// Server's Parameters::set.
  [[nodiscard]] std::optional<std::string> set(const server::Parameter& parameter);

  /// Waits for a change of the state by a client, or until the next frame is due, `patience` at most. Returns the
  /// state.
  [[nodiscard]] PlaybackState wait(std::chrono::milliseconds patience);

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] PlaybackState state() const;
  [[nodiscard]] std::int64_t last() const { return static_cast<std::int64_t>(stamps_ns_.size()) - 1; }
  [[nodiscard]] double time_s(std::int64_t frame) const;
  [[nodiscard]] double seconds_since_first(std::uint64_t stamp_ns) const;
  [[nodiscard]] std::optional<std::string> change(const server::Parameter& parameter);
  void schedule(Clock::time_point from);
  void advance();

  const std::vector<std::uint64_t> stamps_ns_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_changed_{true};
  PlaybackState state_;
  Clock::time_point due_;  // time of the next frame, while playing
};

/// Frames that `view` plays and `export` makes a page of.
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
  /// Sends the messages of a frame, always to the same publisher. Throws InputError.
  virtual void send(std::size_t frame, messages::Sink& sink) = 0;
};

/// The files of a frame as the result that wrote them. Arrays that the run has not written are unknown: a missing world
/// grid is sampled from the vehicle grid. Stages, warnings and ground are empty. Throws InputError: without occupancy.
[[nodiscard]] FrameResult stored_result(const io::RunReader& run, const io::RunFrame& frame);

/// Frames of a run's folder, with left images while its input is where it was. Throws InputError.
[[nodiscard]] std::unique_ptr<PlayedFrames> stored_frames(const std::filesystem::path& folder);

/// Frames of a recording, of the only one in a run's folder, or stored_frames(). Throws InputError.
[[nodiscard]] std::unique_ptr<PlayedFrames> played_frames(const std::filesystem::path& path);

/// The same of several runs, side by side: frames are those of the first; the others follow by stamp, with the last
/// frame that is not later, or their first. All topics of a run are below "/NAME": recording_name(), followed by
/// its number if an earlier run has that name. A single run's topics stay as they are. Throws InputError.
[[nodiscard]] std::unique_ptr<PlayedFrames> played_frames(const std::vector<std::string>& runs);

/// The last name in the path of a run or a recording, for people.
[[nodiscard]] std::string recording_name(const std::filesystem::path& path);
/// The names of several, as their topics have them, separated by commas.
[[nodiscard]] std::string recording_names(const std::vector<std::string>& runs);

}  // namespace stereogrid::app
