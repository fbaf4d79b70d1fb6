// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <string>
#include <vector>

namespace stereogrid::dds {

/// Range of the discovery of peers. localhost: this machine through any interface, as in Jazzy; loopback: 127.0.0.1
/// only (ROS_LOCALHOST_ONLY of Humble). Nodes of both ranges do not find each other.
enum class DiscoveryRange { subnet, localhost, loopback, off };

/// Network of ROS's environment variables.
struct Network {
  dds_domainid_t domain{0};
  DiscoveryRange range{DiscoveryRange::subnet};
  std::vector<std::string> static_peers{};  ///< addresses or names of hosts
};

/// ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS. Throws
/// ConfigError: invalid number, range or host.
[[nodiscard]] Network network_of_environment();

/// Domain of Cyclone DDS, shared by the nodes of a process. CYCLONEDDS_URI overrides its configuration.
class Domain {
 public:
  /// Throws DeviceError.
  explicit Domain(const Network& network);
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;
  ~Domain();

  [[nodiscard]] dds_domainid_t id() const { return id_; }

 private:
  dds_domainid_t id_;
};

/// Returns `code`. Throws DeviceError with `what` if it is an error of Cyclone DDS.
dds_return_t checked(dds_return_t code, const std::string& what);

}  // namespace stereogrid::dds
