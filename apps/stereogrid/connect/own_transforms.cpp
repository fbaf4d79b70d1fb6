// SPDX-License-Identifier: Apache-2.0
#include "connect/message_output.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"

namespace stereogrid::app {
namespace {

using messages::tf2_msgs::TFMessage;

constexpr std::size_t depth{100};             // as tf2_ros has it
constexpr std::chrono::seconds listening{1};  // discovery of other nodes, and their next message

TFMessage decoded(std::span<const std::byte> cdr) {
  TFMessage message;
  messages::decode(cdr, message);
  return message;
}

}  // namespace

OwnTransforms::OwnTransforms(std::shared_ptr<dds::Node> node) : node_{std::move(node)} {
  for (const char* topic : {"/tf", "/tf_static"}) {
    const bool is_latched{std::string_view{topic} == "/tf_static"};
    node_->subscribe(
        topic, std::string{TFMessage::type_name}, depth,
        [others = others_](std::span<const std::byte> cdr) {
          const TFMessage message{decoded(cdr)};
          const std::scoped_lock lock{others->mutex};
          for (const auto& one : message.transforms) others->parents[one.child_frame_id] = one.header.frame_id;
        },
        is_latched);
  }
}

std::uint32_t OwnTransforms::add(const messages::Channel& channel) {
  const std::uint32_t number{node_->sink().add(channel)};
  if (channel.type == TFMessage::type_name) transforms_[number] = channel.topic;
  return number;
}

void OwnTransforms::send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) {
  const bool is_listening{Clock::now() - opened_ < listening};
  if (held_ && !is_listening) {
    const Held held{*std::exchange(held_, std::nullopt)};
    send(held.channel, held.stamp_ns, held.cdr);
  }
  const auto topic{transforms_.find(channel)};
  if (topic == transforms_.end()) return node_->sink().send(channel, stamp_ns, cdr);
  if (is_listening) {
    if (topic->second == "/tf_static") held_ = {channel, stamp_ns, {cdr.begin(), cdr.end()}};
  } else if (!is_published_by_others(topic->second, cdr)) {
    node_->sink().send(channel, stamp_ns, cdr);
  }
}

bool OwnTransforms::is_published_by_others(const std::string& topic, std::span<const std::byte> cdr) {
  const std::scoped_lock lock{others_->mutex};
  for (const auto& own : decoded(cdr).transforms) {
    const auto other{others_->parents.find(own.child_frame_id)};
    if (other == others_->parents.end()) continue;
    if (reported_.insert(own.child_frame_id).second) {
      spdlog::warn(
          "another node publishes the transform {} → {}: {} → {} is not published on {}. Use the robot's poses "
          "(--poses tf), or frames of another name (--ros2-frames WORLD,VEHICLE).",
          io::printable(other->second, 60), io::printable(other->first, 60), io::printable(own.header.frame_id, 60),
          io::printable(own.child_frame_id, 60), topic);
    }
    return true;
  }
  return false;
}

}  // namespace stereogrid::app
