// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
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
[[nodiscard]] std::string complaint_on_binary(std::string_view bytes);

}  // namespace stereogrid::server
