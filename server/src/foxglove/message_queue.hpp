// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "stereogrid/server/server.hpp"

namespace stereogrid::server {

/// Sources of ServerCounts; counted on the server's thread and on those that send.
struct Counters {
  std::atomic<std::size_t> clients{0};
  std::atomic<std::uint64_t> clients_ever{0};
  std::atomic<std::uint64_t> messages_sent{0};
  std::atomic<std::uint64_t> bytes_sent{0};
  std::atomic<std::uint64_t> messages_dropped{0};
  std::atomic<std::uint64_t> faults{0};
  std::atomic<std::uint64_t> refused{0};
  std::atomic<std::uint64_t> http_requests{0};
};

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
  bool is_reported_{false};
};

}  // namespace stereogrid::server
