// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "foxglove/hub.hpp"
#include "foxglove/message_queue.hpp"
#include "http/message.hpp"
#include "http/site.hpp"

namespace stereogrid::server {

namespace net = boost::asio;
namespace beast = boost::beast;
using Tcp = net::ip::tcp;
using Error = beast::error_code;

inline std::string text_of(beast::string_view text) {
  return {text.data(), text.size()};
}

class Session;

/// State that all sessions share, on the server's thread.
struct Surroundings {
  Hub& hub;
  const Site& site;
  const Limits& limits;
  Counters& counters;
  std::set<Session*> sessions{};
  std::function<void()> emptied{};  ///< called when the last session has gone
};

/// A client's connection, from its acceptance to its end; it exists while an operation of it is pending.
class Session : public std::enable_shared_from_this<Session> {
 public:
  using Time = std::chrono::steady_clock::time_point;

  Session(Surroundings& around, const Tcp::socket& socket) : around_{around} {
    Error unconnected;
    address_ = socket.remote_endpoint(unconnected).address();
    around_.sessions.insert(this);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual ~Session() {
    around_.sessions.erase(this);
    if (around_.sessions.empty() && around_.emptied) around_.emptied();
  }

  /// Ends it politely; and at once.
  virtual void stop() = 0;
  virtual void cut() = 0;

  /// The client's.
  [[nodiscard]] const net::ip::address& address() const { return address_; }
  /// Time of the last request or part of a reply that is complete; none: no newer connection may replace this one.
  [[nodiscard]] std::optional<Time> progress() const { return progress_; }

 protected:
  Surroundings& around_;
  std::optional<Time> progress_;

 private:
  net::ip::address address_;
};

/// A connection that uses HTTP; a WebSocket begins as one.
class HttpSession : public Session {
 public:
  HttpSession(Tcp::socket socket, Surroundings& around);

  void read();
  void stop() override { cut(); }
  void cut() override;

 private:
  /// Gives the client the time of one request, or of one piece of a reply.
  void expect_step();
  void on_read(Error error);
  void on_request();
  void upgrade(const HttpRequest& request);
  [[nodiscard]] HttpRequest request() const;
  void reply(HttpReply reply, bool with_body, bool keep_alive);
  void on_header(Error error);
  void write_piece();
  /// The next bytes of the body; none: the end, or the file has become shorter.
  [[nodiscard]] net::const_buffer piece();
  void finish();
  void linger();

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<beast::http::request_parser<beast::http::empty_body>> parser_;
  std::optional<beast::http::response<beast::http::empty_body>> header_;
  std::optional<beast::http::response_serializer<beast::http::empty_body>> serializer_;
  Body body_;
  std::uint64_t sent_{0};
  std::uint64_t length_{0};  ///< bytes of the body to be sent
  bool keep_alive_{false};
  std::string piece_;
};

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
