// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "stereogrid/server/channel.hpp"

namespace stereogrid::server {

/// A message as all queues share it.
struct Message {
  ChannelId channel;
  std::uint64_t stamp_ns;
  std::vector<std::byte> payload;
};
using SharedMessage = std::shared_ptr<const Message>;

struct QueueLimits {
  std::size_t bytes;     ///< size of all messages; a single one may be larger
  std::size_t messages;  ///< number for each channel
};

/// First in, first out, within limits: an excess drops the channel's own oldest messages, or,
/// where it has none, those of the channel that takes the most room.
class MessageQueue {
 public:
  explicit MessageQueue(QueueLimits limits) : limits_{limits} {}

  /// Returns the number of messages dropped.
  std::size_t push(SharedMessage message);
  /// None: it is empty.
  [[nodiscard]] SharedMessage pop();
  void remove(ChannelId channel);
  [[nodiscard]] bool empty() const { return messages_.empty(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  struct Share {
    std::size_t messages{0};
    std::size_t bytes{0};
  };

  void count_out(const Message& message);
  void drop_oldest(ChannelId channel);
  [[nodiscard]] ChannelId largest() const;

  QueueLimits limits_;
  std::deque<SharedMessage> messages_;
  std::map<ChannelId, Share> shares_;  ///< only of channels that have messages here
  std::size_t bytes_{0};
};

}  // namespace stereogrid::server
