// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "stereogrid/mcap/writer.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::app {

/// Messages into an MCAP file, logged at their stamps. Every function throws DeviceError where the file cannot be
/// written.
class McapSink final : public messages::Sink {
 public:
  /// A file of this name is replaced. `all`: of all topics those of points of one label are left out, since `points`
  /// has them.
  McapSink(const std::filesystem::path& file, bool all);

  std::uint32_t add(const messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return channels_.at(channel).is_wanted; }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;
  /// Nothing can be sent afterwards.
  void close() { writer_.close(); }

 private:
  struct Open {
    std::uint16_t id;
    std::uint32_t sent;
    bool is_wanted;
  };

  mcap::Writer writer_;
  bool all_;
  std::vector<Open> channels_;
};

}  // namespace stereogrid::app
