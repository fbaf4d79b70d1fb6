// SPDX-License-Identifier: Apache-2.0
#include "net/http_session.hpp"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <utility>

namespace stereogrid::server {
namespace {

namespace http = beast::http;

constexpr std::size_t largest_header{std::size_t{16} << 10};
constexpr std::uint64_t largest_piece{std::uint64_t{64} << 10};
constexpr std::size_t longest_linger{std::size_t{1} << 20};

std::string field(const http::fields& fields, http::field name) {
  return text_of(fields[name]);
}

std::string joined(const http::fields& fields, http::field name) {
  std::string all;
  const auto [first, last]{fields.equal_range(name)};
  for (auto one{first}; one != last; ++one) all += (all.empty() ? "" : ",") + text_of(one->value());
  return all;
}

/// Reply to an unreadable request; none: the client has gone, or sends nothing.
std::optional<HttpReply> reply_to(const Error& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return plain_reply(431, "The request's header is too long.");
  }
  if (error == http::error::body_limit) return plain_reply(413, "A request must not have a body here.");
  if (error == http::error::end_of_stream || error == http::error::partial_message) return std::nullopt;
  if (error.category() != http::make_error_code(http::error::bad_method).category()) return std::nullopt;
  return plain_reply(400, "The request is malformed: " + error.message() + ".");
}

}  // namespace

HttpSession::HttpSession(Tcp::socket socket, Surroundings& around)
    : Session{around, socket}, stream_{std::move(socket)}, buffer_{2 * largest_header} {}

void HttpSession::cut() {
  progress_.reset();
  stream_.close();
}

void HttpSession::expect_step() {
  progress_ = std::chrono::steady_clock::now();
  stream_.expires_after(around_.limits.http_timeout);
}

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(largest_header));
  expect_step();
  http::async_read_header(stream_, buffer_, *parser_,
                          [this, self = shared_from_this()](Error error, std::size_t) { on_read(error); });
}

void HttpSession::on_read(Error error) {
  if (!error) return on_request();
  if (auto words{reply_to(error)}) reply(std::move(*words), true, false);
}

void HttpSession::on_request() {
  ++around_.counters.http_requests;
  const HttpRequest asked{request()};
  if (beast::websocket::is_upgrade(parser_->get())) return upgrade(asked);
  HttpReply answer{around_.site.answer(asked)};
  if (answer.status == 401 || answer.status == 403) ++around_.counters.refused;
  // the rest of a body would be taken for the next request
  reply(std::move(answer), asked.method != "HEAD", parser_->keep_alive() && !asked.has_body);
}

void HttpSession::upgrade(const HttpRequest& request) {
  auto refusal{around_.site.refuse_websocket(request)};
  if (!refusal && around_.counters.clients >= around_.limits.clients) {
    refusal = plain_reply(503, "There are as many clients as there may be: try again when one has gone.");
  }
  if (!refusal && buffer_.size() > 0) refusal = plain_reply(400, "Wait for the reply before sending messages.");
  if (refusal) {
    ++around_.counters.refused;
    return reply(std::move(*refusal), true, false);
  }
  progress_.reset();
  stream_.expires_never();  // the WebSocket has times of its own
  std::make_shared<WebSocketSession>(std::move(stream_), around_)->accept(parser_->release(), request.subprotocols);
}

HttpRequest HttpSession::request() const {
  const auto& message{parser_->get()};
  HttpRequest asked;
  asked.method = text_of(message.method_string());
  asked.target = text_of(message.target());
  if (message.count(http::field::host) == 1) asked.host = field(message, http::field::host);
  asked.origin = joined(message, http::field::origin);
  asked.authorization = field(message, http::field::authorization);
  asked.cookie = joined(message, http::field::cookie);
  std::ranges::replace(asked.cookie, ',', ';');
  asked.range = field(message, http::field::range);
  asked.if_range = field(message, http::field::if_range);
  asked.if_none_match = joined(message, http::field::if_none_match);
  asked.subprotocols = joined(message, http::field::sec_websocket_protocol);
  asked.has_body = parser_->chunked() || parser_->content_length().value_or(0) > 0;
  return asked;
}

void HttpSession::reply(HttpReply reply, bool with_body, bool keep_alive) {
  header_.emplace(static_cast<http::status>(reply.status), 11);
  for (const auto& [name, value] : reply.fields) header_->insert(name, value);
  if (reply.status != 304) header_->content_length(length_of(reply.body));
  header_->keep_alive(keep_alive);
  body_ = std::move(reply.body);
  length_ = with_body ? length_of(body_) : 0;
  sent_ = 0;
  keep_alive_ = keep_alive;
  serializer_.emplace(*header_);
  expect_step();
  http::async_write_header(stream_, *serializer_,
                           [this, self = shared_from_this()](Error error, std::size_t) { on_header(error); });
}

void HttpSession::on_header(Error error) {
  if (!error) write_piece();
}

void HttpSession::write_piece() {
  if (sent_ == length_) return finish();
  const net::const_buffer bytes{piece()};
  if (bytes.size() == 0) return cut();  // the length was promised already
  sent_ += bytes.size();
  expect_step();
  net::async_write(stream_, bytes, [this, self = shared_from_this()](Error error, std::size_t) { on_header(error); });
}

net::const_buffer HttpSession::piece() {
  const std::uint64_t size{std::min(largest_piece, length_ - sent_)};
  if (const auto* const text{std::get_if<std::string>(&body_)}) return net::buffer(text->data() + sent_, size);
  if (const auto* const shared{std::get_if<std::shared_ptr<const std::string>>(&body_)}) {
    return net::buffer((*shared)->data() + sent_, size);
  }
  const auto& part{std::get<FilePart>(body_)};
  piece_.resize(size);
  const ssize_t count{::pread(part.file->get(), piece_.data(), size, static_cast<off_t>(part.begin + sent_))};
  return net::buffer(piece_.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
}

void HttpSession::finish() {
  body_ = std::string{};
  if (keep_alive_) return read();
  Error ignored;
  stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
  buffer_.clear();
  length_ = 0;
  sent_ = 0;
  expect_step();
  linger();
}

// Closed with bytes unread, a connection is reset, and the client may lose the reply.
void HttpSession::linger() {
  piece_.resize(largest_piece);
  stream_.async_read_some(net::buffer(piece_), [this, self = shared_from_this()](Error error, std::size_t count) {
    sent_ += count;
    if (!error && sent_ < longest_linger) linger();
  });
}

}  // namespace stereogrid::server
