// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <mutex>

#include "counters.hpp"
#include "foxglove/message_queue.hpp"

namespace stereogrid::server {

/// Queue in which any thread leaves messages for the server's thread. Its lock is never held for longer than a queue
/// operation, and it holds no more than the queue's limits, however long the server's thread is busy.
class Inbox {
 public:
  Inbox(QueueLimits limits, Counters& counters) : counters_{counters}, queue_{limits} {}

  void open(ChannelId channel, bool latched);
  /// Drops what waits of it.
  void close(ChannelId channel);
  void set_subscribers(ChannelId channel, std::size_t count);
  [[nodiscard]] bool wanted(ChannelId channel) const;

  /// Whether the server's thread has to be notified to fetch messages: not if it was already notified.
  [[nodiscard]] bool put(SharedMessage message);
  /// The next message; none: the inbox is empty, and put() will ask for the server's thread again.
  [[nodiscard]] SharedMessage take();

 private:
  struct Interest {
    bool latched{false};
    std::size_t subscribers{0};
  };

  Counters& counters_;
  mutable std::mutex mutex_;
  std::map<ChannelId, Interest> channels_;
  MessageQueue queue_;
  bool told_{false};
};

}  // namespace stereogrid::server
