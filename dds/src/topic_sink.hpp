// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "participant.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::dds {

/// A writer of DDS for each channel.
class TopicSink final : public messages::Sink {
 public:
  /// `participant` must be destroyed first: its threads report subscribers.
  TopicSink(Participant& participant, std::vector<std::string> left_out)
      : participant_{participant}, left_out_{std::move(left_out)} {}

  std::uint32_t add(const messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override;
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

 private:
  struct Writer {
    std::string topic;  ///< in ROS
    bool is_latched;
    Warnings& warnings;
    dds_entity_t entity{0};  ///< 0: left out
    ddsi_sertype* type{nullptr};
  };
  static void tell_refused(dds_entity_t entity, dds_offered_incompatible_qos_status_t status, void* writer) noexcept;

  Participant& participant_;
  std::vector<std::string> left_out_;
  std::vector<std::unique_ptr<Writer>> writers_;
};

}  // namespace stereogrid::dds
