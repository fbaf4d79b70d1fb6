// SPDX-License-Identifier: Apache-2.0
#include "net/http_session.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/post.hpp>
#include <utility>

#include "foxglove/protocol.hpp"

namespace stereogrid::server {
namespace {

namespace websocket = beast::websocket;

constexpr std::chrono::milliseconds closing_farewell{1000};
constexpr std::size_t longest_reason{120};  // 123 fit into the frame

/// Data in the system's buffer can no longer be replaced by something newer.
void keep_system_queue_short(Tcp::socket& socket) {
  const int bytes{256 << 10};
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, sizeof bytes);
}

}  // namespace

WebSocketSession::WebSocketSession(beast::tcp_stream stream, Surroundings& around)
    : Session{around, stream.socket()}, stream_{std::move(stream)}, patience_{stream_.get_executor()} {
  const auto& limits{around_.limits};
  stream_.set_option(websocket::stream_base::timeout{limits.http_timeout, limits.idle_timeout, true});
  stream_.read_message_max(limits.request_bytes);
  stream_.auto_fragment(false);
  keep_system_queue_short(beast::get_lowest_layer(stream_).socket());
}

void WebSocketSession::accept(beast::http::request<beast::http::empty_body> request, const std::string& subprotocols) {
  request_ = std::move(request);
  const std::string chosen{chosen_subprotocol(subprotocols).value_or("")};
  stream_.set_option(websocket::stream_base::decorator([chosen](websocket::response_type& response) {
    response.set(beast::http::field::sec_websocket_protocol, chosen);
  }));
  stream_.async_accept(request_, [this, self = self()](Error error) { on_accepted(error); });
}

void WebSocketSession::on_accepted(Error error) {
  if (error || closing_) return;
  if (around_.counters.clients >= around_.limits.clients) {  // others were quicker with the handshake
    ++around_.counters.refused;
    return close(close_code::try_again_later, "as many clients as there may be");
  }
  client_ = around_.hub.join(*this);
  read();
}

void WebSocketSession::read() {
  stream_.async_read(buffer_, [this, self = self()](Error error, std::size_t) { on_read(error); });
}

void WebSocketSession::on_read(Error error) {
  if (error) return on_closed();
  const auto bytes{buffer_.cdata()};
  around_.hub.receive(*client_, {static_cast<const char*>(bytes.data()), bytes.size()}, stream_.got_binary(),
                      std::chrono::steady_clock::now());
  buffer_.consume(buffer_.size());
  read();
}

void WebSocketSession::wake() {
  if (std::exchange(busy_, true)) return;
  net::post(stream_.get_executor(), [this, self = self()] { write(); });
}

void WebSocketSession::write() {
  frame_.reset();
  if (client_ && !closing_) frame_ = around_.hub.next(*client_);
  busy_ = frame_.has_value();
  if (!busy_) return;
  stream_.binary(frame_->binary);
  const net::const_buffer payload{frame_->message
                                      ? net::buffer(frame_->message->payload.data(), frame_->message->payload.size())
                                      : net::const_buffer{}};
  stream_.async_write(std::array{net::const_buffer{net::buffer(frame_->head)}, payload},
                      [this, self = self()](Error error, std::size_t) {
                        if (!error) write();  // else reading fails, too
                      });
}

void WebSocketSession::close(std::uint16_t code, const std::string& reason) {
  if (std::exchange(closing_, true)) return;
  net::post(stream_.get_executor(), [this, self = self(), code, text = reason.substr(0, longest_reason)] {
    if (!stream_.is_open()) return;
    patience_.expires_after(closing_farewell);
    patience_.async_wait([this, self](Error error) {
      if (!error) cut();
    });
    stream_.async_close({static_cast<websocket::close_code>(code), text}, [this, self](Error) { patience_.cancel(); });
  });
}

void WebSocketSession::stop() {
  if (!client_) return cut();  // amid the handshake
  close(close_code::going_away, "the server goes away");
}

void WebSocketSession::cut() {
  beast::get_lowest_layer(stream_).close();
}

void WebSocketSession::on_closed() {
  if (client_) around_.hub.leave(*std::exchange(client_, std::nullopt));
  if (!closing_) cut();  // ends pending writes
}

}  // namespace stereogrid::server
