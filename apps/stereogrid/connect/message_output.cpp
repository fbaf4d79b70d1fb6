// SPDX-License-Identifier: Apache-2.0
#include "connect/message_output.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "cli/program.hpp"
#include "connect/mavlink.hpp"
#include "pictures/drawing.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/writer.hpp"
#include "stereogrid/messages/sink.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 6> topics_of_stages{"disparity",
                                                           "points",
                                                           "obstacle_points",
                                                           "ground_points",
                                                           "left/image_annotated/compressed",
                                                           "u_disparity/compressed"};

/// Makes its folder.
const fs::path& ready(const fs::path& file) {
  if (file.has_parent_path()) io::create_folder(file.parent_path());
  return file;
}

std::vector<std::string> scale_names() {
  constexpr auto names{names_of(OccupancyScale{})};
  return {names.begin(), names.end()};
}

OccupancyScale scale_named(std::string_view name) {
  constexpr auto names{names_of(OccupancyScale{})};
  return static_cast<OccupancyScale>(std::ranges::find(names, name) - names.begin());
}

messages::FrameMessagesOptions sent_by(const MessageOptions& options) {
  messages::FrameMessagesOptions sent{.scale = options.scale.value_or(OccupancyScale::percent),
                                      .points_voxel_m = options.points_voxel_m};
  if (options.ros2.frames.size() == 2) {
    sent.world_frame = options.ros2.frames[0];
    sent.vehicle_frame = options.ros2.frames[1];
  }
  return sent;
}

}  // namespace

void add_recording_option(Command command, MessageOptions& options, bool has_folder) {
  const std::string description{
      "Record the results as ROS 2 messages, too (docs/messages.md), for 'view', Foxglove, Lichtblick or ros2 bag."};
  if (!has_folder) {
    command.add_option("--mcap FILE.mcap", options.mcap, description);
    return;
  }
  command.add_option("--mcap [FILE.mcap]", options.mcap, description + " Without a file: DIR/run.mcap.")
      .optional_value(MessageOptions::in_run_folder);
}

void add_message_options(Command command, MessageOptions& options) {
  command.group(Group::messages);
  command.add_option("--mcap-topics TOPIC,TOPIC,...", options.topics,
                     "Topics to record, such as occupancy_grid,obstacles,tf; without disparity, points and images "
                     "the file is small.");
  command
      .add_option_function(
          "--value-scale", [&options](const std::string& name) { options.scale = scale_named(name); },
          "Scale of the values of occupancy grid messages: nav2 for Nav2's static layer "
          "(docs/ros2.md). Otherwise percent.")
      .one_of(scale_names());
  command
      .add_option("--points-voxel M", options.points_voxel_m,
                  "Side of the voxels with one point each in clouds of points; 0: all points.")
      .check(number(0, 10))
      .show_default();
  command.add_option("--mavlink HOST:PORT", options.mavlink,
                     "Send OBSTACLE_DISTANCE of MAVLink to PX4 or ArduPilot by UDP (docs/live.md).");
  command.add_flag("--ros2", options.ros2.publishes,
                   "Publish the same messages as topics of a ROS 2 node, in the domain ROS_DOMAIN_ID (docs/ros2.md).");
  add_ros2_options(command, options.ros2);
}

void check(const MessageOptions& options, const Rig& rig) {
  if (options.ros2.publishes) {
    const std::string world_frame{sent_by(options).world_frame};
    if (options.scale == OccupancyScale::autoware && world_frame != "map") {
      throw ConfigError{fmt::format(
          "--value-scale autoware: grids would be in the frame {} (allowed map, in which Autoware reads them). Give "
          "--ros2-frames map,stereo_grid, and poses of map, such as --poses tf.",
          world_frame)};
    }
    check(options.ros2);
  }
  if (!options.mavlink.empty()) static_cast<void>(MavlinkSender{options.mavlink});
  messages::Tee nowhere{{}};
  static_cast<void>(messages::FrameMessages{nowhere, rig, {.points_voxel_m = options.points_voxel_m}});
  if (options.mcap.empty()) {
    if (options.topics.empty()) return;
    throw ConfigError{"--mcap-topics needs a recording. Give --mcap FILE, too."};
  }
  if (io::is_file(options.mcap) || io::is_folder(options.mcap)) {
    throw ConfigError{fmt::format("--mcap {}: it is there already. Give another name, or delete it.",
                                  io::printable_path(options.mcap))};
  }
  try {
    const messages::FrameMessages names{nowhere, rig, {.topics = options.topics}};
  } catch (const ConfigError& error) {
    throw ConfigError{fmt::format("--mcap-topics: {}", error.what())};
  }
}

bool has_receivers(const MessageOptions& options) {
  return !options.mcap.empty() || options.ros2.publishes || !options.mavlink.empty();
}

bool needs_stages(const MessageOptions& options) {
  const std::vector<std::string>& topics{options.topics};
  if (options.ros2.publishes) return true;
  return !options.mcap.empty() && (topics.empty() || std::ranges::any_of(topics_of_stages, [&](std::string_view topic) {
                                     return std::ranges::find(topics, topic) != topics.end();
                                   }));
}

/// Messages into an MCAP file, logged at their stamps. Every function throws DeviceError where the file cannot be
/// written.
class McapSink final : public messages::Sink {
 public:
  /// A file of this name is replaced. `all`: of all topics those of points of one label are left out, since `points`
  /// has them.
  McapSink(const fs::path& file, bool all) : writer_{file}, all_{all} {}

  std::uint32_t add(const messages::Channel& channel) override {
    const bool is_recorded{!all_ || !channel.topic.ends_with("_points")};
    Open& open{channels_.emplace_back(Open{0, 0, is_recorded})};
    if (!is_recorded) return static_cast<std::uint32_t>(channels_.size() - 1);
    const mcap::OfferedQos qos{.depth = channel.latched ? 1 : 10, .transient_local = channel.latched};
    const std::uint16_t schema{writer_.add_schema(channel.type, "ros2msg", channel.definition)};
    open.id =
        writer_.add_channel(channel.topic, "cdr", schema, {{"offered_qos_profiles", mcap::offered_qos_profiles(qos)}});
    return static_cast<std::uint32_t>(channels_.size() - 1);
  }
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return channels_.at(channel).is_recorded; }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override {
    // MCAP has no times before 1970
    const auto time_ns{static_cast<std::uint64_t>(std::max<std::int64_t>(stamp_ns, 0))};
    Open& open{channels_.at(channel)};
    writer_.write(open.id, ++open.sent, time_ns, time_ns, cdr);
  }
  /// Nothing can be sent afterwards.
  void close() { writer_.close(); }

 private:
  struct Open {
    std::uint16_t id;
    std::uint32_t sent;
    bool is_recorded;
  };

  mcap::Writer writer_;
  bool all_;
  std::vector<Open> channels_;
};

/// As viewer_sink(). A topic is advertised when there is something to send
/// on it for the first time.
class ServerSink final : public messages::Sink {
 public:
  explicit ServerSink(server::Server& server) : server_{server} {}

  std::uint32_t add(const messages::Channel& channel) override {
    server::Channel advertised;
    advertised.topic = channel.topic;
    advertised.schema_name = channel.type;
    advertised.schema = channel.definition;
    advertised.latched = channel.latched;
    channels_.push_back(server_.add_channel(std::move(advertised)));
    return static_cast<std::uint32_t>(channels_.size() - 1);
  }
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return server_.wanted(channels_.at(channel)); }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override {
    server_.send(channels_.at(channel), static_cast<std::uint64_t>(stamp_ns), cdr);
  }

 private:
  server::Server& server_;
  std::vector<server::ChannelId> channels_;
};

struct MessageOutput::State {
  State(const MessageOptions& options, server::Server* viewers, const Rig& first_rig) : rig{first_rig} {
    std::vector<messages::Sink*> sinks;
    if (options.ros2.publishes) {
      sinks.push_back(&published.emplace(open_ros2_node(options.ros2)));
    }
    if (!options.mavlink.empty()) mavlink.emplace(options.mavlink);
    if (viewers != nullptr) sinks.push_back(&live.emplace(*viewers));
    if (!options.mcap.empty()) {
      recording.emplace(ready(options.mcap), options.topics.empty());
      if (options.topics.empty()) sinks.push_back(&*recording);
    }
    messages::FrameMessagesOptions sent{sent_by(options)};
    if (!sinks.empty()) senders.emplace_back(all.emplace(std::move(sinks)), rig, sent);
    if (options.topics.empty()) return;
    sent.topics = options.topics;
    senders.emplace_back(*recording, rig, sent);
  }

  Rig rig;
  std::optional<OwnTransforms> published;
  std::optional<MavlinkSender> mavlink;
  std::optional<McapSink> recording;
  std::optional<ServerSink> live;
  std::optional<messages::Tee> all;
  std::vector<messages::FrameMessages> senders;
  bool has_warned{false};
};

std::unique_ptr<messages::Sink> viewer_sink(server::Server& server) {
  return std::make_unique<ServerSink>(server);
}

MessageOutput::MessageOutput(const MessageOptions& options, server::Server* viewers, const Rig& rig)
    : state_{std::make_unique<State>(options, viewers, rig)} {}

MessageOutput::~MessageOutput() = default;

void MessageOutput::send(const StereoFrame& frame, const FrameResult& result, messages::FrameFacts facts) {
  std::vector<std::vector<std::uint8_t>> left(std::max<std::size_t>(result.cameras.size(), 1));
  std::vector<std::vector<std::uint8_t>> u_disparity(left.size());
  facts.stamp_ns = frame.stamp_ns;
  // seconds of ROS have 32 bits, and times of MCAP begin in 1970
  const bool has_stamp{frame.stamp_ns >= 0 &&
                       frame.stamp_ns / 1'000'000'000 <= std::numeric_limits<std::int32_t>::max()};
  if (!has_stamp && !std::exchange(state_->has_warned, true)) {
    spdlog::warn(
        "messages have no stamps before 1970 or after 2038: {} s becomes the nearest of them. Correct the clock of the "
        "cameras.",
        frame.stamp_ns / 1'000'000'000);
  }
  if (!result.stages.occupancy.empty()) {
    const auto once = [&](std::vector<std::vector<std::uint8_t>>& jpegs, int camera, const auto& make) {
      std::vector<std::uint8_t>& jpeg{jpegs.at(static_cast<std::size_t>(camera))};
      const CameraImage image{image_of(frame, result, camera)};
      if (jpeg.empty() && image.frame != nullptr) jpeg = make(image);
      return std::as_bytes(std::span{jpeg});
    };
    facts.left_jpeg = [&, once](int camera) { return once(left, camera, annotated_jpeg); };
    facts.u_disparity_jpeg = [&, once](int camera) { return once(u_disparity, camera, u_disparity_jpeg); };
  }
  for (messages::FrameMessages& sender : state_->senders) {
    if (result.rig != state_->rig) sender.set_rig(result.rig);
    sender.send(result, facts);
  }
  if (state_->mavlink) state_->mavlink->send(result, frame.stamp_ns);
  state_->rig = result.rig;
}

void MessageOutput::finish() {
  if (state_->recording) state_->recording->close();
}

}  // namespace stereogrid::app
