// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "participant.hpp"
#include "stereogrid/dds/node.hpp"
#include "subscriptions.hpp"
#include "topic_sink.hpp"

namespace stereogrid::dds {

class NetworkNode final : public Node {
 public:
  /// Throws ConfigError, DeviceError.
  explicit NetworkNode(const NodeOptions& options);
  ~NetworkNode() override;

  [[nodiscard]] messages::Sink& sink() override { return *sink_; }
  [[nodiscard]] std::vector<PublishedTopic> topics() const override;
  void subscribe(const std::string& topic, const std::string& type, std::size_t depth, Take take,
                 bool is_latched) override;
  void unsubscribe(const std::string& topic) override;

 private:
  std::optional<Participant> participant_;
  std::optional<TopicSink> sink_;
  std::optional<Subscriptions> subscriptions_;
};

}  // namespace stereogrid::dds
