// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "connect/server_sink.hpp"

namespace stereogrid::app {

std::uint32_t ServerSink::add(const messages::Channel& channel) {
  server::Channel advertised;
  advertised.topic = channel.topic;
  advertised.schema_name = channel.type;
  advertised.schema = channel.definition;
  advertised.latched = channel.latched;
  channels_.push_back(server_.add_channel(std::move(advertised)));
  return static_cast<std::uint32_t>(channels_.size() - 1);
}

void ServerSink::send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) {
  server_.send(channels_.at(channel), static_cast<std::uint64_t>(stamp_ns), cdr);
}

}  // namespace stereogrid::app
