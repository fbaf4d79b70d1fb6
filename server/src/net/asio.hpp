// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <string>

namespace stereogrid::server {

namespace net = boost::asio;
namespace beast = boost::beast;
using Tcp = net::ip::tcp;
using Error = beast::error_code;

inline std::string text_of(beast::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace stereogrid::server
