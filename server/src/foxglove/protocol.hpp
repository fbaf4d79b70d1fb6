// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "stereogrid/server/server.hpp"

namespace stereogrid::server {

/// Chosen by the client.
using SubscriptionId = std::uint32_t;

struct Subscription {
  SubscriptionId id;
  ChannelId channel;
};

struct Subscribe {
  std::vector<Subscription> subscriptions;
};
struct Unsubscribe {
  std::vector<SubscriptionId> ids;
};
struct GetParameters {
  std::vector<std::string> names;  ///< none: all
  std::optional<std::string> id;
};
struct SetParameters {
  std::vector<Parameter> parameters;  ///< values of the types that JSON has; the parameter's own type may be another
  std::optional<std::string> id;
};
struct SubscribeParameters {
  std::vector<std::string> names;  ///< none: all
};
struct UnsubscribeParameters {
  std::vector<std::string> names;  ///< none: all
};
struct SubscribeGraph {};
struct UnsubscribeGraph {};

/// Requests that a client may send.
using Request = std::variant<Subscribe, Unsubscribe, GetParameters, SetParameters, SubscribeParameters,
                             UnsubscribeParameters, SubscribeGraph, UnsubscribeGraph>;

/// Reads a client's text message. Throws InputError: what is wrong with it, for the client to read.
[[nodiscard]] Request parse_request(std::string_view text);

/// Error message on a client's binary message: this server takes none.
[[nodiscard]] std::string error_on_binary(std::string_view bytes);

// The server's messages of the Foxglove WebSocket protocol, version 1 (github.com/foxglove/ws-protocol).
// Text that is no UTF-8 is mended with U+FFFD.

struct Features {
  bool parameters;
  bool time;
};
[[nodiscard]] std::string server_info(const std::string& name, const std::string& session, Features features);
[[nodiscard]] std::string status(StatusLevel level, std::string_view text);
[[nodiscard]] std::string advertise(const std::map<ChannelId, const Channel*>& channels);
[[nodiscard]] std::string unadvertise(ChannelId id);
/// `request`: the id of what it answers; none: an update.
[[nodiscard]] std::string parameter_values(std::span<const Parameter* const> parameters,
                                           const std::optional<std::string>& request);

/// Subscribers by topic; all topics are there.
using Graph = std::map<std::string, std::vector<std::string>>;
[[nodiscard]] std::string connection_graph(const std::string& publisher, const Graph& graph,
                                           const std::set<std::string>& removed_topics);

/// Bytes before a message's own.
[[nodiscard]] std::string message_head(SubscriptionId subscription, std::uint64_t stamp_ns);
[[nodiscard]] std::string time_message(std::uint64_t stamp_ns);

/// The first of ours in a header Sec-WebSocket-Protocol; none: the client uses another protocol. Both names stand for
/// the same messages: older viewers know foxglove.websocket.v1 only, newer ones foxglove.sdk.v1 only.
[[nodiscard]] std::optional<std::string> chosen_subprotocol(std::string_view header);

}  // namespace stereogrid::server
