// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid::mcap {

/// Definition of a message type. `data`: in the language of `encoding`, "ros2msg" for ROS 2.
struct Schema {
  std::string name;  ///< type, such as "nav_msgs/msg/OccupancyGrid"
  std::string encoding;
  std::string data;

  bool operator==(const Schema&) const = default;
};

/// Messages of one type on one topic.
struct Channel {
  std::uint16_t schema_id{0};  ///< 0: none
  std::string topic;
  std::string message_encoding;  ///< "cdr" for ROS 2
  std::map<std::string, std::string> metadata;

  bool operator==(const Channel&) const = default;
};

struct Message {
  std::uint16_t channel{0};  ///< Reader: the channel's id; Bag: index in Bag::topics()
  std::uint32_t sequence{0};
  std::uint64_t log_time_ns{0};      ///< time of recording
  std::uint64_t publish_time_ns{0};  ///< time of publication
  std::span<const std::byte> data;   ///< valid until the next message is read
};

/// Sequence of messages.
class STEREOGRID_EXPORT MessageCursor {
 public:
  MessageCursor() = default;
  MessageCursor(const MessageCursor&) = delete;
  MessageCursor& operator=(const MessageCursor&) = delete;
  virtual ~MessageCursor() = default;

  /// Valid until the next call; nullptr: there are no more. Throws InputError; DeviceError: the disk.
  virtual const Message* next() = 0;
};

/// Which messages.
struct Selection {
  std::vector<std::string> topics{};                                 ///< empty: all
  std::uint64_t first_ns{0};                                         ///< log time, this one included
  std::uint64_t last_ns{std::numeric_limits<std::uint64_t>::max()};  ///< this one included
};

/// Unreadable parts of a file. A reader continues where possible and lists here what it skipped.
struct Damage {
  std::uint64_t chunks_skipped{0};
  std::uint64_t messages_skipped{0};   ///< whole ones, whose channel is declared nowhere
  std::vector<std::string> sentences;  ///< damage and its position; 20 at most

  [[nodiscard]] bool any() const { return !sentences.empty(); }
};

}  // namespace stereogrid::mcap
