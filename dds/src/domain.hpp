// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <string>
#include <vector>

namespace stereogrid::dds {

/// Where peers are searched for. localhost: on this machine through any interface, as Jazzy's middlewares do; loopback:
/// through 127.0.0.1 alone (ROS_LOCALHOST_ONLY of Humble), where peers of the former are not found.
enum class DiscoveryRange { subnet, localhost, loopback, off };

/// Network of ROS's environment variables.
struct Network {
  dds_domainid_t domain{0};
  DiscoveryRange range{DiscoveryRange::subnet};
  std::vector<std::string> static_peers{};  ///< addresses or names of hosts
};

/// ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS. Throws ConfigError: no such
/// number, range or host.
[[nodiscard]] Network network_of_environment();

/// A domain as Cyclone DDS calls its part of a process; nodes of one process share it. CYCLONEDDS_URI has the last
/// word.
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

/// Throws DeviceError where that is an error's code of Cyclone DDS; `what` could not be made. Returns it else.
dds_return_t checked(dds_return_t code, const std::string& what);

}  // namespace stereogrid::dds
