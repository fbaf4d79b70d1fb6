// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"

namespace stereogrid::server {

/// Clients that are served.
struct AccessRules {
  bool loopback{true};  ///< listens where only this machine reaches it
  std::string address;  ///< as in a URL: an IPv6 address is in brackets
  std::string token;    ///< empty: none is needed
  std::string cookie;   ///< its name
  std::vector<std::string> allowed_origins;
};

/// Why a request is refused.
struct Refusal {
  int status;
  std::string words;
};

/// A page of another site may have its name point to this machine (DNS rebinding); the header Host then has that name.
[[nodiscard]] std::optional<Refusal> refuse_host(const AccessRules& rules, const HttpRequest& request);
/// Browsers let any page open a WebSocket anywhere, and say in the header Origin which page it was.
[[nodiscard]] std::optional<Refusal> refuse_origin(const AccessRules& rules, const HttpRequest& request);
/// The token is in the query, in a header "Authorization: Bearer …", or in the cookie that a page was given.
[[nodiscard]] std::optional<Refusal> refuse_token(const AccessRules& rules, const HttpRequest& request,
                                                  const Target& target);

/// In a time that does not depend on where they differ.
[[nodiscard]] bool equal_in_constant_time(std::string_view a, std::string_view b);

/// 160 random bits as 40 hexadecimal digits. Throws DeviceError.
[[nodiscard]] std::string random_token();
/// Throws ConfigError: short, or of other characters than letters, digits, '-' and '_'.
void check_token(std::string_view token);

}  // namespace stereogrid::server
