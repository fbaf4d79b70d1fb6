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

/// How the messages of a type are described. `data`: in the words of `encoding`, "ros2msg" for ROS 2.
struct Schema {
  std::string name;  ///< of the type, "nav_msgs/msg/OccupancyGrid"
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
  std::uint16_t channel{0};  ///< of a Reader: the channel's id; of a Bag: index in Bag::topics()
  std::uint32_t sequence{0};
  std::uint64_t log_time_ns{0};      ///< when it was recorded
  std::uint64_t publish_time_ns{0};  ///< when it was sent
  std::span<const std::byte> data;   ///< valid until the next message is asked for
};

/// Messages one after the other.
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

/// What could not be read of a file. A reader goes on where it can, and says here what it left out.
struct Damage {
  std::uint64_t chunks_skipped{0};
  std::uint64_t messages_skipped{0};   ///< whole ones, whose channel is declared nowhere
  std::vector<std::string> sentences;  ///< what is wrong and where; no more than 20

  [[nodiscard]] bool any() const { return !sentences.empty(); }
};

}  // namespace stereogrid::mcap
