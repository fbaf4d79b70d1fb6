// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/messages/sink.hpp"

namespace stereogrid_ros {

/// Publishes encoded messages. Topics whose message package is not installed are left out with a warning.
class PublisherSink final : public stereogrid::messages::Sink {
 public:
  /// `node` must outlive this object.
  explicit PublisherSink(rclcpp_lifecycle::LifecycleNode& node) : node_{node} {}

  std::uint32_t add(const stereogrid::messages::Channel& channel) override {
    const rclcpp::QoS qos{channel.latched ? rclcpp::QoS{1}.transient_local() : rclcpp::QoS{10}};
    Topic& topic{topics_.emplace_back(Topic{nullptr, channel.latched})};
    try {
      topic.publisher = node_.create_generic_publisher(channel.topic, std::string{channel.type}, qos);
    } catch (const std::exception& error) {
      RCLCPP_WARN(node_.get_logger(), "%s is not published: %s", channel.topic.c_str(), error.what());
    }
    return static_cast<std::uint32_t>(topics_.size() - 1);
  }

  [[nodiscard]] bool wants(std::uint32_t channel) const override {
    const Topic& topic{topics_.at(channel)};
    return topic.publisher && (topic.latched || topic.publisher->get_subscription_count() > 0);
  }

  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    if (!topics_.at(channel).publisher) return;
    message_.reserve(cdr.size());
    rcl_serialized_message_t& bytes{message_.get_rcl_serialized_message()};
    std::memcpy(bytes.buffer, cdr.data(), cdr.size());
    bytes.buffer_length = cdr.size();
    topics_.at(channel).publisher->publish(message_);
  }

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
