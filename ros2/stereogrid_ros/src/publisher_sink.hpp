// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <span>
#include <vector>

#include "stereogrid/messages/sink.hpp"

namespace stereogrid_ros {

/// Publishes encoded messages. Topics whose message package is not installed are left out with a warning.
class PublisherSink final : public stereogrid::messages::Sink {
 public:
  /// `node` must outlive this object.
  explicit PublisherSink(rclcpp_lifecycle::LifecycleNode& node) : node_{node} {}

  std::uint32_t add(const stereogrid::messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override;
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;
  /// Removes all publishers, with their latched messages.
  void clear() { topics_.clear(); }

 private:
  struct Topic {
    rclcpp::GenericPublisher::SharedPtr publisher;  // empty: left out
    bool latched;
  };

  rclcpp_lifecycle::LifecycleNode& node_;
  std::vector<Topic> topics_;
  rclcpp::SerializedMessage message_;  // its memory is reused
};

}  // namespace stereogrid_ros
