// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

namespace stereogrid::app {

/// systemd, where it has started this program as a service of Type=notify (sd_notify(3): the socket that NOTIFY_SOCKET
/// names). Without one nothing happens.
class ServiceManager {
 public:
  ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;
  ~ServiceManager();

  void notify_ready();
  /// Sends the watchdog notification, at most once a second; call it more often.
  void notify_alive();

 private:
  void send(const std::string& words) const;

  int socket_{-1};
  std::chrono::steady_clock::time_point reported_{};
};

}  // namespace stereogrid::app
