// SPDX-License-Identifier: Apache-2.0
#include "participant.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <random>
#include <sstream>

#include "stereogrid/error.hpp"

namespace stereogrid::dds {
namespace {

constexpr dds_domainid_t last_domain{232};  // by the ports of RTPS

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

DiscoveryRange range() {
  const std::string local{variable("ROS_LOCALHOST_ONLY")};
  if (!local.empty() && local != "0" && local != "1") {
    throw ConfigError{"ROS_LOCALHOST_ONLY is \"" + local + "\", but it is 0 or 1."};
  }
  const std::string range{variable("ROS_AUTOMATIC_DISCOVERY_RANGE")};
  if (local == "1" || range == "LOCALHOST") return DiscoveryRange::localhost;
  if (range.empty() || range == "SUBNET" || range == "SYSTEM_DEFAULT") return DiscoveryRange::subnet;
  if (range == "OFF") return DiscoveryRange::off;
  throw ConfigError{"ROS_AUTOMATIC_DISCOVERY_RANGE: " + range + " (allowed SUBNET, LOCALHOST, OFF, SYSTEM_DEFAULT)."};
}

std::vector<std::string> static_peers() {
  std::vector<std::string> peers;
  if (variable("ROS_LOCALHOST_ONLY") == "1") return peers;  // as rcl has it
  std::istringstream text{variable("ROS_STATIC_PEERS")};
  for (std::string peer; std::getline(text, peer, ';');) {
    const auto is_of_host{[](unsigned char letter) {
      return std::isalnum(letter) != 0 ||
             std::string_view{".:-_[]"}.find(static_cast<char>(letter)) != std::string_view::npos;
    }};
    if (!std::ranges::all_of(peer, is_of_host)) {
      throw ConfigError{"ROS_STATIC_PEERS: " + peer + " (allowed addresses and names of hosts, with ; between them)."};
    }
    if (!peer.empty()) peers.push_back(std::move(peer));
  }
  return peers;
}

// A receiver with small buffers, such as Fast DDS with its defaults, loses packets of a large message. It requests at
// most 256 fragments at once, and each is repaired alone; Cyclone's own 1344 bytes make 1400 fragments of 1.9 MB. A
// packet of 14720 bytes (MaxMessageSize) has one of these instead of ten.
constexpr const char* fragments{
    "<CycloneDDS><Domain><General><FragmentSize>14000B</FragmentSize></General></Domain></CycloneDDS>,"};

/// Discovery as rmw_cyclonedds_cpp configures it for the same variables. Listed peers are contacted at the ports of the
/// first 33 participants of a host, without multicast. `loopback`: as a second interface, for nodes of Humble with
/// ROS_LOCALHOST_ONLY, which have it alone.
std::string config_of(const Network& network, bool loopback) {
  if (network.range == DiscoveryRange::off) {
    return "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></"
           "General><Discovery><ParticipantIndex>none"
           "</ParticipantIndex><Tag>stereogrid_" +
           std::to_string(std::random_device{}()) + "</Tag></Discovery></Domain></CycloneDDS>,";
  }
  const bool is_local{network.range == DiscoveryRange::localhost};
  if (!is_local && network.static_peers.empty()) return "";
  std::string peers{is_local ? "<Peer address=\"127.0.0.1\"/>" : ""};
  for (const std::string& peer : network.static_peers) peers += "<Peer address=\"" + peer + "\"/>";
  const char* const interfaces{
      loopback ? "<Interfaces><NetworkInterface autodetermine=\"true\"/><NetworkInterface address=\"127.0.0.1\"/>"
                 "</Interfaces>"
               : ""};
  const std::string general{
      is_local ? std::string{"<General>"} + interfaces + "<AllowMulticast>false</AllowMulticast></General>" : ""};
  return std::string{"<CycloneDDS><Domain>"} + general +
         "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</"
         "MaxAutoParticipantIndex><Peers>" +
         peers + "</Peers></Discovery></Domain></CycloneDDS>,";
}

struct Shared {
  dds_entity_t entity;
  int users;
};

std::mutex mutex;  // guards domains()
std::map<dds_domainid_t, Shared>& domains() {
  static std::map<dds_domainid_t, Shared> all;
  return all;
}

}  // namespace

Network network_of_environment() {
  return {domain_id(), range(), static_peers()};
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
  const auto created = [&](bool loopback) {
    const std::string config{fragments + config_of(network, loopback) + variable("CYCLONEDDS_URI")};
    return dds_create_domain(id_, config.c_str());
  };
  dds_entity_t entity{created(true)};
  if (entity == DDS_RETCODE_ERROR) entity = created(false);  // loopback is the only interface
  if (entity == DDS_RETCODE_PRECONDITION_NOT_MET) return;    // the program has opened it
  checked(entity, "domain " + std::to_string(id_) + " cannot be opened (check CYCLONEDDS_URI and the network)");
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
