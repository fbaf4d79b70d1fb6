// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::messages {

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
