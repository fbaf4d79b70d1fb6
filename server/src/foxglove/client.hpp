// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "foxglove/message_queue.hpp"
#include "foxglove/protocol.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::server {

/// Reasons to close a WebSocket (RFC 6455, 7.4.1, and its registry).
namespace close_code {
inline constexpr std::uint16_t going_away{1001};
inline constexpr std::uint16_t policy{1008};
inline constexpr std::uint16_t try_again_later{1013};
}  // namespace close_code

/// A client's connection, as the protocol sees it. Its functions return at once and do not call back.
class Link {
 public:
  Link() = default;
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  virtual ~Link() = default;

  /// There is something to send: to be fetched with Hub::next() when it can be written.
  virtual void wake() = 0;
  virtual void close(std::uint16_t code, const std::string& reason) = 0;
};

/// Content of one WebSocket message: the head, then the payload of the message, if there is one.
struct Frame {
  bool binary;
  std::string head;
  SharedMessage message;
};

/// An amount per second on average, twice as much at once: requests, or their bytes.
class RequestRate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit RequestRate(int per_second) : per_second_{static_cast<double>(per_second)}, left_{2 * per_second_} {}
  /// False: too much.
  [[nodiscard]] bool take(Time now, double amount = 1);

 private:
  double per_second_;
  double left_;
  Time last_{};
};

/// State of a client. Content that newer content may replace (the time, the graph, parameters) is not
/// queued as text: it is marked as due, and written as it is when the client can take it.
struct Client {
  Client(Link& its_link, std::string its_name, const Limits& limits)
      : link{its_link},
        name{std::move(its_name)},
        messages{{limits.queue_bytes, limits.queue_messages}},
        rate{limits.requests_per_second},
        byte_rate{limits.request_bytes_per_second} {}

  Link& link;
  std::string name;  ///< in the connection graph
  std::map<SubscriptionId, ChannelId> subscriptions;
  std::map<ChannelId, SubscriptionId> channels;  ///< the same, the other way round
  std::set<std::string> watched_parameters;
  bool watches_graph{false};

  std::deque<std::string> control;
  std::size_t control_bytes{0};
  std::optional<std::uint64_t> time_due;
  bool graph_due{false};
  std::set<std::string> removed_topics;  ///< to be sent with the graph
  std::set<std::string> parameters_due;
  MessageQueue messages;

  RequestRate rate;
  RequestRate byte_rate;
  int faults{0};
  bool closed{false};
};

}  // namespace stereogrid::server
