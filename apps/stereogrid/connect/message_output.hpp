// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "connect/ros2_node.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::server {
class Server;
}

namespace stereogrid::app {

class Command;

/// Which recording, and which topics of docs/messages.md.
struct MessageOptions {
  /// --mcap without a file: the recording goes into the folder of the run.
  static constexpr const char* in_run_folder{"/"};

  std::filesystem::path mcap;           ///< empty: none; in_run_folder: the file has no name of its own
  std::vector<std::string> topics;      ///< topics of the recording; empty: all
  std::optional<OccupancyScale> scale;  ///< none: percent
  double points_voxel_m{0.1};           ///< FrameMessagesOptions::points_voxel_m
  std::string mavlink;                  ///< HOST:PORT; "": none
  Ros2Options ros2{};
};

/// --mcap; `has_folder`: of a command with a folder of results, where the recording goes if no file is given.
void add_recording_option(Command command, MessageOptions& options, bool has_folder);
/// All others.
void add_message_options(Command command, MessageOptions& options);

/// Throws ConfigError: a topic that does not exist, topics without a file, a file that is there already.
void check(const MessageOptions& options, const Rig& rig);

/// True if messages are recorded, published or sent.
[[nodiscard]] bool has_receivers(const MessageOptions& options);

/// True if a message is recorded or published that needs FrameResult::stages.
[[nodiscard]] bool needs_stages(const MessageOptions& options);

/// Messages to the viewers of a server, which has to live longer.
[[nodiscard]] std::unique_ptr<messages::Sink> viewer_sink(server::Server& server);

/// Publishes the results of each frame as ROS 2 messages: to an MCAP file, viewers and ROS 2.
class MessageOutput {
 public:
  /// `viewers`: has to live longer; nullptr: none. `rig`: of the first frame. Throws ConfigError, DeviceError.
  MessageOutput(const MessageOptions& options, server::Server* viewers, const Rig& rig);
  ~MessageOutput();

  /// `facts`: all but the stamp and the images; `rig`: of this frame. Throws DeviceError.
  void send(const StereoFrame& frame, const FrameResult& result, messages::FrameFacts facts);
  /// The file is whole. Throws DeviceError.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::app
