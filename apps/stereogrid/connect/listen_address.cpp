// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "connect/listen_address.hpp"

#include <charconv>

#include "stereogrid/error.hpp"

namespace stereogrid::app {

ListenAddress listen_address_of(const std::string& text) {
  ListenAddress made;
  const std::size_t colon{text.rfind(':')};
  const char* const end{text.data() + text.size()};
  const char* const digits{colon == std::string::npos ? end : text.data() + colon + 1};
  const auto [stop, error]{std::from_chars(digits, end, made.port)};
  std::string address{text.substr(0, colon == std::string::npos ? 0 : colon)};
  const bool bracketed{address.size() > 2 && address.front() == '[' && address.back() == ']'};
  if (bracketed) address = address.substr(1, address.size() - 2);
  const bool ambiguous{!bracketed && address.find(':') != std::string::npos};
  if (error != std::errc{} || stop != end || ambiguous) {
    throw ConfigError{"'" + text +
                      "' is no place to listen. Give ADDRESS:PORT, such as 127.0.0.1:8765 or [::1]:8765; port 0 "
                      "takes any free one."};
  }
  if (!address.empty()) made.address = address;
  return made;
}

}  // namespace stereogrid::app
