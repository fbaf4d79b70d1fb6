// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "connect/ros2_node.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/sink.hpp"
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

/// Publisher of a node of ROS 2 that never publishes a transform beside another node: a frame has one parent.
/// Transforms are withheld for the first second, in which those of others are received, and from the moment on when
/// another node publishes one to the same frame. A warning names it, once for each frame.
class OwnTransforms final : public messages::Sink {
 public:
  explicit OwnTransforms(std::shared_ptr<dds::Node> node);

  std::uint32_t add(const messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return node_->sink().wants(channel); }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Others {
    std::mutex mutex;
    std::map<std::string, std::string> parents;  ///< parent of each frame that another node publishes
  };
  struct Held {
    std::uint32_t channel;
    std::int64_t stamp_ns;
    std::vector<std::byte> cdr;
  };

  [[nodiscard]] bool is_published_by_others(const std::string& topic, std::span<const std::byte> cdr);

  std::shared_ptr<dds::Node> node_;
  std::shared_ptr<Others> others_{std::make_shared<Others>()};  // the node has it, too
  std::map<std::uint32_t, std::string> transforms_;             // topics by channel
  std::optional<Held> held_;                                    // static transforms of the first second
  std::set<std::string> reported_;
  Clock::time_point opened_{Clock::now()};
};

}  // namespace stereogrid::app
