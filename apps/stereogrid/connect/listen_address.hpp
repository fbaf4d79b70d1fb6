// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace stereogrid::app {

/// Address and port of a server.
struct ListenAddress {
  std::string address{"127.0.0.1"};
  std::uint16_t port{8765};  ///< 0: any free one
};

/// Parses "ADDRESS:PORT" ("127.0.0.1:8765", "[::1]:8765") or ":PORT" (loopback). Throws ConfigError.
[[nodiscard]] ListenAddress listen_address_of(const std::string& text);

}  // namespace stereogrid::app
