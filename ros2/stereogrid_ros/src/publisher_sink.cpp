// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "publisher_sink.hpp"

#include <cstring>
#include <exception>
#include <string>

namespace stereogrid_ros {

std::uint32_t PublisherSink::add(const stereogrid::messages::Channel& channel) {
  const rclcpp::QoS qos{channel.latched ? rclcpp::QoS{1}.transient_local() : rclcpp::QoS{10}};
  Topic& topic{topics_.emplace_back(Topic{nullptr, channel.latched})};
  try {
    topic.publisher = node_.create_generic_publisher(channel.topic, std::string{channel.type}, qos);
  } catch (const std::exception& error) {
    RCLCPP_WARN(node_.get_logger(), "%s is not published: %s", channel.topic.c_str(), error.what());
  }
  return static_cast<std::uint32_t>(topics_.size() - 1);
}

bool PublisherSink::wants(std::uint32_t channel) const {
  const Topic& topic{topics_.at(channel)};
  return topic.publisher && (topic.latched || topic.publisher->get_subscription_count() > 0);
}

void PublisherSink::send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) {
  if (!topics_.at(channel).publisher) return;
  message_.reserve(cdr.size());
  rcl_serialized_message_t& bytes{message_.get_rcl_serialized_message()};
  std::memcpy(bytes.buffer, cdr.data(), cdr.size());
  bytes.buffer_length = cdr.size();
  topics_.at(channel).publisher->publish(message_);
}

}  // namespace stereogrid_ros
