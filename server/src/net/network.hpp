// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "foxglove/hub.hpp"
#include "foxglove/message_queue.hpp"
#include "http/site.hpp"

namespace stereogrid::server {

/// The sockets: the only interface to Boost.Beast for the rest of the server.
class Network {
 public:
  /// Listens; clients wait until run(). Throws ConfigError, DeviceError as Server does.
  Network(const std::string& address, std::uint16_t port);
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;
  ~Network();

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] bool loopback() const;
  [[nodiscard]] std::string address() const;  ///< as in a URL: an IPv6 address is in brackets

  /// Serves clients until stop(). What it is given has to stay until then.
  void run(Hub& hub, const Site& site, const Limits& limits, Counters& counters);
  /// Has run() do something between requests. From any thread; work posted after stop() may never be done.
  void post(std::function<void()> work);
  /// Makes run() say good-bye to clients and return, within little more than a second.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::server
