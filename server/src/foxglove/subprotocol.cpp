// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "foxglove/subprotocol.hpp"

#include <algorithm>

namespace stereogrid::server {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first{text.find_first_not_of(" \t")};
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::optional<std::string> chosen_subprotocol(std::string_view header) {
  for (std::size_t start{0}; start <= header.size();) {
    const std::size_t end{std::min(header.find(',', start), header.size())};
    const std::string_view name{trimmed(header.substr(start, end - start))};
    if (name == "foxglove.websocket.v1" || name == "foxglove.sdk.v1") return std::string{name};
    start = end + 1;
  }
  return std::nullopt;
}

}  // namespace stereogrid::server
