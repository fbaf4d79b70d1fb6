// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid::messages {

/// A topic and the type of its messages.
struct Channel {
  std::string topic;            ///< absolute name in ROS: "/stereo_grid/occupancy_grid"
  std::string_view type;        ///< "nav_msgs/msg/OccupancyGrid"; static storage, as for the definition
  std::string_view definition;  ///< schema encoding "ros2msg"
  bool latched{false};          ///< late subscribers receive the last message (ROS: transient local, depth 1)
};

/// Publisher of messages to a recording or a network. Called by one thread at a time.
class STEREOGRID_EXPORT Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink();

  /// Adds a channel, at any time before its first message. Returns its number for the other functions.
  virtual std::uint32_t add(const Channel& channel) = 0;
  /// False: no receiver, so messages need not be encoded. Always true for latched channels if the publisher stores
  /// their last messages.
  [[nodiscard]] virtual bool wants(std::uint32_t channel) const = 0;
  /// `cdr`: valid during the call only.
  virtual void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) = 0;
};

/// Several publishers as one: messages are encoded once. The publishers must outlive it.
class STEREOGRID_EXPORT Tee final : public Sink {
 public:
  explicit Tee(std::vector<Sink*> sinks);

  std::uint32_t add(const Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override;
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

 private:
  std::vector<Sink*> sinks_;
  std::vector<std::vector<std::uint32_t>> channels_;  // by channel: its number at each publisher
};

}  // namespace stereogrid::messages
