// SPDX-License-Identifier: Apache-2.0
#include "live/service_manager.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string_view>

namespace stereogrid::app {

ServiceManager::ServiceManager() {
  const char* const named{std::getenv("NOTIFY_SOCKET")};
  const std::string_view path{named == nullptr ? "" : named};
  sockaddr_un address{};
  if (path.size() < 2 || path.size() >= sizeof address.sun_path || (path[0] != '/' && path[0] != '@')) return;
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  if (path[0] == '@') address.sun_path[0] = '\0';  // a name without a file
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ >= 0 && connect(socket_, reinterpret_cast<const sockaddr*>(&address), size) == 0) return;
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) close(socket_);
}

void ServiceManager::send(const std::string& words) const {
  // never blocks
  if (socket_ >= 0) static_cast<void>(::send(socket_, words.data(), words.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
}

void ServiceManager::notify_ready() {
  send("READY=1");
}

void ServiceManager::notify_alive() {
  constexpr std::chrono::seconds every{1};
  const auto now = std::chrono::steady_clock::now();
  if (now - reported_ < every) return;
  reported_ = now;
  send("WATCHDOG=1");
}

}  // namespace stereogrid::app
