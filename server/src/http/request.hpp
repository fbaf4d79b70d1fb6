// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace stereogrid::server {

/// Evaluated parts of an HTTP request; a header that is not there is empty.
struct HttpRequest {
  std::string method;
  std::string target;
  std::string host;  ///< empty also where there are several
  std::string origin;
  std::string authorization;
  std::string cookie;
  std::string range;
  std::string if_range;
  std::string if_none_match;
  std::string subprotocols;  ///< Sec-WebSocket-Protocol, all of them
  bool has_body{false};
};

}  // namespace stereogrid::server
