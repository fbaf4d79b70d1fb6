// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "foxglove/hub.hpp"
#include "foxglove/message_queue.hpp"
#include "http/site.hpp"

namespace stereogrid::server {

namespace net = boost::asio;
namespace beast = boost::beast;
using Tcp = net::ip::tcp;
using Error = beast::error_code;

inline std::string text_of(beast::string_view text) {
  return {text.data(), text.size()};
}

class Session;

/// State that all sessions share, on the server's thread.
struct Surroundings {
  Hub& hub;
  const Site& site;
  const Limits& limits;
  Counters& counters;
  std::set<Session*> sessions{};
  std::function<void()> emptied{};  ///< called when the last session has gone
};

/// A client's connection, from its acceptance to its end; it exists while an operation of it is pending.
class Session : public std::enable_shared_from_this<Session> {
 public:
  using Time = std::chrono::steady_clock::time_point;

  Session(Surroundings& around, const Tcp::socket& socket) : around_{around} {
    Error unconnected;
    address_ = socket.remote_endpoint(unconnected).address();
    around_.sessions.insert(this);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual ~Session() {
    around_.sessions.erase(this);
    if (around_.sessions.empty() && around_.emptied) around_.emptied();
  }

  /// Ends it politely; and at once.
  virtual void stop() = 0;
  virtual void cut() = 0;

  /// The client's.
  [[nodiscard]] const net::ip::address& address() const { return address_; }
  /// Time of the last request or part of a reply that is complete; none: no newer connection may replace this one.
  [[nodiscard]] std::optional<Time> progress() const { return progress_; }

 protected:
  Surroundings& around_;
  std::optional<Time> progress_;

 private:
  net::ip::address address_;
};

}  // namespace stereogrid::server
