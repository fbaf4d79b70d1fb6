// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <memory>
#include <optional>
#include <string>

#include "net/session.hpp"

namespace stereogrid::server {

/// A WebSocket client of the hub.
class WebSocketSession : public Session, public Link {
 public:
  WebSocketSession(beast::tcp_stream stream, Surroundings& around);

  /// Answers the handshake, which may be: `subprotocols` has one of ours.
  void accept(beast::http::request<beast::http::empty_body> request, const std::string& subprotocols);

  void wake() override;
  void close(std::uint16_t code, const std::string& reason) override;
  void stop() override;
  void cut() override;

 private:
  void on_accepted(Error error);
  void read();
  void on_read(Error error);
  void write();
  void on_closed();
  [[nodiscard]] std::shared_ptr<WebSocketSession> self() {
    return std::static_pointer_cast<WebSocketSession>(shared_from_this());
  }

  beast::websocket::stream<beast::tcp_stream> stream_;
  net::steady_timer patience_;  ///< for a client's answer to being closed
  beast::http::request<beast::http::empty_body> request_;
  beast::flat_buffer buffer_;
  std::optional<ClientId> client_;  ///< none: not yet, or no more, known to the hub
  std::optional<Frame> frame_;      ///< being written
  bool busy_{false};                ///< a frame is being written, or about to be fetched
  bool closing_{false};
};

}  // namespace stereogrid::server
