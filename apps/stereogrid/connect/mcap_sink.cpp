// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "connect/mcap_sink.hpp"

#include <algorithm>

namespace stereogrid::app {

McapSink::McapSink(const std::filesystem::path& file, bool all) : writer_{file}, all_{all} {}

std::uint32_t McapSink::add(const messages::Channel& channel) {
  const bool is_wanted{!all_ || !channel.topic.ends_with("_points")};
  Open& open{channels_.emplace_back(Open{0, 0, is_wanted})};
  if (!is_wanted) return static_cast<std::uint32_t>(channels_.size() - 1);
  const mcap::OfferedQos qos{.depth = channel.latched ? 1 : 10, .transient_local = channel.latched};
  const std::uint16_t schema{writer_.add_schema(channel.type, "ros2msg", channel.definition)};
  open.id =
      writer_.add_channel(channel.topic, "cdr", schema, {{"offered_qos_profiles", mcap::offered_qos_profiles(qos)}});
  return static_cast<std::uint32_t>(channels_.size() - 1);
}

void McapSink::send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) {
  // MCAP has no times before 1970
  const auto time_ns{static_cast<std::uint64_t>(std::max<std::int64_t>(stamp_ns, 0))};
  Open& open{channels_.at(channel)};
  writer_.write(open.id, ++open.sent, time_ns, time_ns, cdr);
}

}  // namespace stereogrid::app
