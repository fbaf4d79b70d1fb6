// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/dds/node.hpp"
#include "stereogrid/messages/message.hpp"

namespace stereogrid::dds {

constexpr const char* discovery_topic{"ros_discovery_info"};
constexpr const char* discovery_type{"rmw_dds_common/msg/ParticipantEntitiesInfo"};

/// Number of a participant or endpoint in ROS's list: that of DDS, then zeros.
template <std::size_t bytes>
struct Gid {
  STEREOGRID_MESSAGE("rmw_dds_common/msg/Gid", data);

  std::array<std::uint8_t, bytes> data{};
};

template <std::size_t bytes>
struct NodeEntitiesInfo {
  STEREOGRID_MESSAGE("rmw_dds_common/msg/NodeEntitiesInfo", node_namespace, node_name, reader_gid_seq, writer_gid_seq);

  std::string node_namespace;
  std::string node_name;
  std::vector<Gid<bytes>> reader_gid_seq;
  std::vector<Gid<bytes>> writer_gid_seq;
};

/// The nodes of a participant, by which tools of ROS know who publishes what.
template <std::size_t bytes>
struct ParticipantEntitiesInfo {
  STEREOGRID_MESSAGE(discovery_type, gid, node_entities_info_seq);

  Gid<bytes> gid;
  std::vector<NodeEntitiesInfo<bytes>> node_entities_info_seq;
};

/// A node with all that it reads and writes.
struct Entities {
  std::string node_namespace;
  std::string node;
  dds_guid_t participant{};
  std::vector<dds_guid_t> readers{};
  std::vector<dds_guid_t> writers{};
};

/// Encoded as peers of that distribution read it.
[[nodiscard]] std::vector<std::byte> discovery_message(const Entities& entities, Distro distro);
/// Layout of a peer's message; none: neither.
[[nodiscard]] std::optional<Distro> layout_of(std::span<const std::byte> cdr);

}  // namespace stereogrid::dds
