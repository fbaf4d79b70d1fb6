// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace stereogrid::server {

/// Identifier of a channel, as clients see it; never used twice by one server.
using ChannelId = std::uint32_t;

/// A stream of messages that clients can subscribe to.
struct Channel {
  std::string topic;
  std::string encoding{"cdr"};  ///< encoding of its messages
  std::string schema_name;      ///< such as nav_msgs/msg/OccupancyGrid
  std::string schema;           ///< the definition as text, with those of the types within it
  std::string schema_encoding{"ros2msg"};
  /// The last message is kept, even without subscribers, and sent to a new subscriber at once.
  bool latched{false};
};

}  // namespace stereogrid::server
