// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "domain.hpp"

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string_view>

#include "stereogrid/error.hpp"

namespace stereogrid::dds {
namespace {

constexpr dds_domainid_t last_domain{232};  // by the ports of RTPS

// Found also where the loopback has no multicast: the first processes of the machine are asked one by one.
constexpr std::string_view local_only{
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>,"};

std::string variable(const char* name) {
  const char* const value{std::getenv(name)};
  return value == nullptr ? "" : value;
}

dds_domainid_t domain_id() {
  const std::string text{variable("ROS_DOMAIN_ID")};
  if (text.empty()) return 0;
  dds_domainid_t id{0};
  const char* const end{text.data() + text.size()};
  if (const auto [stop, error]{std::from_chars(text.data(), end, id)};
      error != std::errc{} || stop != end || id > last_domain) {
    throw ConfigError{"ROS_DOMAIN_ID is \"" + text + "\", but a domain is a number from 0 to 232."};
  }
  return id;
}

bool is_local() {
  const std::string local{variable("ROS_LOCALHOST_ONLY")};
  if (!local.empty() && local != "0" && local != "1") {
    throw ConfigError{"ROS_LOCALHOST_ONLY is \"" + local + "\", but it is 0 or 1."};
  }
  if (local == "1") return true;
  const std::string range{variable("ROS_AUTOMATIC_DISCOVERY_RANGE")};
  if (range.empty() || range == "SUBNET" || range == "SYSTEM_DEFAULT") return false;
  if (range == "LOCALHOST") return true;
  throw ConfigError{"ROS_AUTOMATIC_DISCOVERY_RANGE is \"" + range +
                    "\", which is not known here: SUBNET, LOCALHOST or SYSTEM_DEFAULT."};
}

struct Shared {
  dds_entity_t entity;
  int users;
};

std::mutex mutex;  // of the domains that this process has made
std::map<dds_domainid_t, Shared>& domains() {
  static std::map<dds_domainid_t, Shared> all;
  return all;
}

}  // namespace

Network network_of_environment() {
  return {domain_id(), is_local()};
}

dds_return_t checked(dds_return_t code, const std::string& what) {
  if (code >= 0) return code;
  throw DeviceError{"ROS 2: " + what + ": " + dds_strretcode(code) + "."};
}

Domain::Domain(const Network& network) : id_{network.domain} {
  const std::scoped_lock lock{mutex};
  if (const auto found{domains().find(id_)}; found != domains().end()) {
    ++found->second.users;
    return;
  }
  const std::string config{std::string{network.is_local ? local_only : ""} + variable("CYCLONEDDS_URI")};
  const dds_entity_t entity{dds_create_domain(id_, config.c_str())};
  if (entity == DDS_RETCODE_PRECONDITION_NOT_MET) return;  // the program's own
  checked(entity, "domain " + std::to_string(id_) + " cannot be opened (is CYCLONEDDS_URI right, is there a network?)");
  domains()[id_] = {entity, 1};
}

Domain::~Domain() {
  const std::scoped_lock lock{mutex};
  const auto found{domains().find(id_)};
  if (found == domains().end() || --found->second.users > 0) return;
  dds_delete(found->second.entity);
  domains().erase(found);
}

}  // namespace stereogrid::dds
