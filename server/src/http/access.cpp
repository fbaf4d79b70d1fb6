// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "http/site.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

std::string lower(std::string_view text) {
  std::string result{text};
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// Without the port: a user who forwards the port (ssh -L) may have chosen another one.
std::string host_name(std::string_view host) {
  const std::size_t colon{host.rfind(':')};
  const std::size_t bracket{host.rfind(']')};
  const bool has_port{colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket)};
  return lower(has_port ? host.substr(0, colon) : host);
}

std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  for (std::size_t start{0}; start < cookies.size();) {
    const std::size_t end{std::min(cookies.find(';', start), cookies.size())};
    std::string_view pair{cookies.substr(start, end - start)};
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (pair.starts_with(name) && pair.substr(name.size()).starts_with('=')) return pair.substr(name.size() + 1);
    start = end + 1;
  }
  return {};
}

std::string_view bearer(std::string_view authorization) {
  constexpr std::string_view scheme{"bearer "};
  if (lower(authorization.substr(0, scheme.size())) != scheme) return {};
  authorization.remove_prefix(scheme.size());
  authorization.remove_prefix(std::min(authorization.find_first_not_of(' '), authorization.size()));
  return authorization;
}

}  // namespace

std::optional<Refusal> refuse_host(const AccessRules& rules, const HttpRequest& request) {
  if (request.host.empty()) return Refusal{400, "A request needs exactly one header Host."};
  const std::string name{host_name(request.host)};
  if (!rules.loopback || name == "localhost" || name == "127.0.0.1" || name == "[::1]" || name == rules.address) {
    return std::nullopt;
  }
  return Refusal{403, "This server is for this machine only: open it as localhost, 127.0.0.1 or [::1]."};
}

std::optional<Refusal> refuse_origin(const AccessRules& rules, const HttpRequest& request) {
  if (request.origin.empty()) return std::nullopt;  // no browser
  const std::string origin{lower(request.origin)};
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme) && origin.substr(scheme.size()) == lower(request.host)) return std::nullopt;
  }
  const auto is_it{[&](const std::string& allowed) { return lower(allowed) == origin; }};
  if (std::ranges::any_of(rules.allowed_origins, is_it)) return std::nullopt;
  return Refusal{403,
                 "Pages of another site may not connect. Who started the server can allow this page by naming it (" +
                     request.origin.substr(0, 100) + ") among the allowed origins."};
}

std::optional<Refusal> refuse_token(const AccessRules& rules, const HttpRequest& request, const Target& target) {
  if (rules.token.empty()) return std::nullopt;
  const std::string* const asked{target.find("token")};
  const std::string_view candidates[]{asked != nullptr ? std::string_view{*asked} : std::string_view{},
                                      bearer(request.authorization), cookie_value(request.cookie, rules.cookie)};
  for (const std::string_view candidate : candidates) {
    if (equal_in_constant_time(candidate, rules.token)) return std::nullopt;
  }
  return Refusal{401,
                 "A token is needed: open the address that the server printed, with ?token=…, or send a header "
                 "Authorization: Bearer …"};
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference{0};
  for (std::size_t i{0}; i < a.size(); ++i) difference = difference | static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

std::string random_token() {
  std::array<unsigned char, 20> bytes{};
  if (::getentropy(bytes.data(), bytes.size()) != 0) {
    throw DeviceError{"The system gives no random bytes for a token: give one in the options."};
  }
  constexpr char digits[]{"0123456789abcdef"};
  std::string token;
  for (const unsigned char byte : bytes) {
    token.push_back(digits[byte >> 4]);
    token.push_back(digits[byte & 15]);
  }
  return token;
}

void check_token(std::string_view token) {
  constexpr std::size_t shortest{22};  // 128 bits of 6 in a character
  const auto fits{[](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_'; }};
  if (token.size() >= shortest && std::ranges::all_of(token, fits)) return;
  throw ConfigError{"The token has to be of 22 or more letters, digits, '-' and '_'."};
}

}  // namespace stereogrid::server
