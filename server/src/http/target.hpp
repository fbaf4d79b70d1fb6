// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stereogrid::server {

/// Target of a request, decoded.
struct Target {
  std::string path;  ///< from "/"; no empty segment but a last one, no "." or "..", no control character
  std::vector<std::pair<std::string, std::string>> query;

  /// The first of that name; none: there is no such.
  [[nodiscard]] const std::string* find(std::string_view name) const;
};

/// Parses the target of a request line, such as /a%20b?token=x. None: it is malformed, or means something outside.
[[nodiscard]] std::optional<Target> parse_target(std::string_view text);

}  // namespace stereogrid::server
