// SPDX-License-Identifier: Apache-2.0
#include "discovery_info.hpp"

#include <algorithm>

#include "stereogrid/error.hpp"
#include "stereogrid/messages/cdr.hpp"

namespace stereogrid::dds {
namespace {

template <std::size_t bytes>
Gid<bytes> gid_of(const dds_guid_t& guid) {
  Gid<bytes> gid;
  std::ranges::copy(guid.v, gid.data.begin());
  return gid;
}

template <std::size_t bytes>
std::vector<Gid<bytes>> gids_of(const std::vector<dds_guid_t>& guids) {
  std::vector<Gid<bytes>> gids;
  for (const dds_guid_t& guid : guids) gids.push_back(gid_of<bytes>(guid));
  return gids;
}

template <std::size_t bytes>
std::vector<std::byte> encoded(const Entities& entities) {
  const ParticipantEntitiesInfo<bytes> message{
      gid_of<bytes>(entities.participant),
      {{entities.node_namespace, entities.node, gids_of<bytes>(entities.readers), gids_of<bytes>(entities.writers)}}};
  messages::CdrWriter writer;
  const auto cdr{writer.encode(message)};
  return {cdr.begin(), cdr.end()};
}

template <std::size_t bytes>
bool is_layout(std::span<const std::byte> cdr) {
  try {
    ParticipantEntitiesInfo<bytes> message;
    messages::decode(cdr, message);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::vector<std::byte> discovery_message(const Entities& entities, Distro distro) {
  return distro == Distro::jazzy ? encoded<16>(entities) : encoded<24>(entities);
}

std::optional<Distro> layout_of(std::span<const std::byte> cdr) {
  if (is_layout<24>(cdr)) return Distro::humble;
  if (is_layout<16>(cdr)) return Distro::jazzy;
  return std::nullopt;
}

}  // namespace stereogrid::dds
