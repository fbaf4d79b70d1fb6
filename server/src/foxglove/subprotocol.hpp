// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace stereogrid::server {

/// The first of ours in a header Sec-WebSocket-Protocol; none: the client uses another protocol. Both names stand for
/// the same messages: older viewers know foxglove.websocket.v1 only, newer ones foxglove.sdk.v1 only.
[[nodiscard]] std::optional<std::string> chosen_subprotocol(std::string_view header);

}  // namespace stereogrid::server
