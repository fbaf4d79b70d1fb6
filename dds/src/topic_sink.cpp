// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "network_node.hpp"

#include <algorithm>

#include "participant.hpp"

namespace stereogrid::dds {
namespace {

constexpr int depth{10};

}  // namespace

void TopicSink::log_refused(dds_entity_t /*entity*/, dds_offered_incompatible_qos_status_t status,
                            void* writer) noexcept {
  const Writer& one{*static_cast<const Writer*>(writer)};
  try {
    one.warnings.log_once("ROS 2: a subscriber of " + one.topic + " receives nothing: it requires " +
                          policy_in_words(status.last_policy_id) +
                          ", which this topic does not offer. Subscribe without it.");
  } catch (...) {  // no exceptions: called by C
  }
}

std::uint32_t TopicSink::add(const messages::Channel& channel) {
  auto writer{
      std::make_unique<Writer>(participant_.names().topic(channel.topic), channel.latched, participant_.warnings())};
  if (std::ranges::find(left_out_, channel.topic) != left_out_.end()) {
    writers_.push_back(std::move(writer));
    return static_cast<std::uint32_t>(writers_.size() - 1);
  }
  const Listener listener{dds_create_listener(nullptr)};
  dds_lset_offered_incompatible_qos_arg(listener.get(), log_refused, writer.get(), true);
  Qos qos{reliable_qos(channel.latched, channel.latched ? 1 : depth)};
  set_type_hash(qos.get(), channel.type, channel.definition);
  const auto [entity,
              type]{participant_.make_writer(writer->topic, std::string{channel.type}, std::move(qos), listener.get())};
  writer->entity = entity;
  writer->type = type;
  writers_.push_back(std::move(writer));
  return static_cast<std::uint32_t>(writers_.size() - 1);
}

bool TopicSink::wants(std::uint32_t channel) const {
  const Writer& writer{*writers_.at(channel)};
  if (writer.entity == 0) return false;
  if (writer.is_latched) return true;
  dds_publication_matched_status_t status{};
  checked(dds_get_publication_matched_status(writer.entity, &status), writer.topic + " has no subscribers' number");
  return status.current_count > 0;
}

void TopicSink::send(std::uint32_t channel, std::int64_t /*stamp_ns*/, std::span<const std::byte> cdr) {
  const Writer& writer{*writers_.at(channel)};
  if (writer.entity == 0) return;  // other publishers of a Tee may need the channel
  // does not wait: the oldest unread messages are dropped
  checked(dds_writecdr(writer.entity, new_sample(writer.type, cdr)),
          "a message on " + writer.topic + " cannot be sent");
}

}  // namespace stereogrid::dds
