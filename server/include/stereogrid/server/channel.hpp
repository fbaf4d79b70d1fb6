// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace stereogrid::server {

/// Of a channel, as clients see it; never used twice by one server.
using ChannelId = std::uint32_t;

/// A stream of messages that clients can subscribe to.
struct Channel {
  std::string topic;
  std::string encoding{"cdr"};  ///< of its messages
  std::string schema_name;      ///< such as nav_msgs/msg/OccupancyGrid
  std::string schema;           ///< the definition as text, with those of the types within it
  std::string schema_encoding{"ros2msg"};
  bool latched{false};  ///< who subscribes is sent the last message at once; it is kept even while nobody subscribes
};

}  // namespace stereogrid::server
