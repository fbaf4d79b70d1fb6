// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "stereogrid/messages/sink.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::app {

/// Messages to the viewers of a server, which has to live longer. A topic is advertised when there is something to send
/// on it for the first time.
class ServerSink final : public messages::Sink {
 public:
  explicit ServerSink(server::Server& server) : server_{server} {}

  std::uint32_t add(const messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return server_.wanted(channels_.at(channel)); }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

 private:
  server::Server& server_;
  std::vector<server::ChannelId> channels_;
};

}  // namespace stereogrid::app
