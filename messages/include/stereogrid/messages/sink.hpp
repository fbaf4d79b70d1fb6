// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"

namespace stereogrid::messages {

/// A topic and what comes on it.
struct Channel {
  std::string topic;            ///< as ROS has it, from the root: "/stereo_grid/occupancy_grid"
  std::string_view type;        ///< "nav_msgs/msg/OccupancyGrid"; of static duration, as the definition
  std::string_view definition;  ///< schema encoding "ros2msg"
  bool latched{false};          ///< who comes later wants the last message, too (ROS: transient local, depth 1)
};

/// Where messages go: a recording, a network. Called by one thread at a time.
class STEREOGRID_EXPORT Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink();

  /// Before the first message of a topic, which may be at any time; the number is what the other functions take.
  virtual std::uint32_t add(const Channel& channel) = 0;
  /// Would a message go anywhere? It is not even made where not. A sink that keeps the last message of latched channels
  /// wants them always.
  [[nodiscard]] virtual bool wants(std::uint32_t channel) const = 0;
  /// `cdr`: the sender's memory, used again after the call.
  virtual void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) = 0;
};

}  // namespace stereogrid::messages
