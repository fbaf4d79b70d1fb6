// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

bool wait_for(int socket, short events, std::chrono::milliseconds time) {
  pollfd entry{socket, events, 0};
  return ::poll(&entry, 1, static_cast<int>(time.count())) > 0;
}

std::string small(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

HttpAnswer parsed_header(const std::string& text) {
  HttpAnswer answer;
  answer.status = std::stoi(text.substr(text.find(' ') + 1, 3));
  for (std::size_t start{text.find("\r\n") + 2}; start < text.size();) {
    const std::size_t end{std::min(text.find("\r\n", start), text.size())};
    const std::string line{text.substr(start, end - start)};
    if (const std::size_t colon{line.find(": ")}; colon != std::string::npos) {
      answer.fields[small(line.substr(0, colon))] = line.substr(colon + 2);
    }
    start = end + 2;
  }
  return answer;
}

}  // namespace

Wire::Wire(std::uint16_t port, int receive_buffer, const char* address, const char* source)
    : socket_{::socket(AF_INET, SOCK_STREAM, 0)} {
  const int on{1};
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (receive_buffer > 0) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  if (source != nullptr) {
    ::inet_pton(AF_INET, source, &where.sin_addr);
    ::bind(socket_, reinterpret_cast<const sockaddr*>(&where), sizeof where);
  }
  where.sin_port = htons(port);
  ::inet_pton(AF_INET, address, &where.sin_addr);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0) {
    ::close(socket_);
    throw std::runtime_error{"cannot connect to port " + std::to_string(port)};
  }
}

Wire::Wire(Wire&& other) noexcept : socket_{std::exchange(other.socket_, -1)} {}

Wire::~Wire() {
  if (socket_ >= 0) ::close(socket_);
}

void Wire::send(std::string_view bytes) const {
  while (!bytes.empty() && wait_for(socket_, POLLOUT, 1s)) {
    const ssize_t count{::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT)};
    if (count <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

std::string Wire::receive(std::chrono::milliseconds time) const {
  std::array<char, 65536> bytes{};
  if (!wait_for(socket_, POLLIN, time)) return {};
  const ssize_t count{::recv(socket_, bytes.data(), bytes.size(), 0)};
  return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
}

std::string Wire::receive_all(std::chrono::milliseconds time) const {
  std::string all;
  for (const auto end{std::chrono::steady_clock::now() + time}; std::chrono::steady_clock::now() < end;) {
    if (!wait_for(socket_, POLLIN, 100ms)) continue;
    const std::string more{receive(0ms)};
    if (more.empty()) return all;
    all += more;
  }
  throw std::runtime_error{"the other side does not close"};
}

void Wire::reset() {
  const linger at_once{1, 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  ::close(std::exchange(socket_, -1));
}

HttpAnswer ask(const Wire& wire, const std::string& bytes, bool with_body) {
  wire.send(bytes);
  std::string received;
  while (received.find("\r\n\r\n") == std::string::npos) {
    const std::string more{wire.receive()};
    if (more.empty()) throw std::runtime_error{"no answer, but '" + received + "'"};
    received += more;
  }
  const std::size_t end{received.find("\r\n\r\n")};
  HttpAnswer answer{parsed_header(received.substr(0, end))};
  answer.body = received.substr(end + 4);
  const auto length{answer.fields.find("content-length")};
  if (!with_body || length == answer.fields.end()) return answer;
  while (answer.body.size() < std::stoul(length->second)) {
    const std::string more{wire.receive()};
    if (more.empty()) throw std::runtime_error{"the answer ends early"};
    answer.body += more;
  }
  return answer;
}

HttpAnswer get(std::uint16_t port, const std::string& target, const std::string& fields, const std::string& method) {
  const std::string host{fields.find("Host: ") == std::string::npos ? "Host: localhost\r\n" : ""};
  return ask(Wire{port}, method + " " + target + " HTTP/1.1\r\n" + host + fields + "\r\n", method != "HEAD");
}

namespace {

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t value{0};
  for (std::size_t i{bytes.size()}; i > 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i - 1]);
  return value;
}

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value{0};
  for (const char c : bytes) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

HttpAnswer shake_hands(const Wire& wire, std::uint16_t port, const Handshake& handshake) {
  const std::string host{handshake.host.empty() ? "127.0.0.1:" + std::to_string(port) : handshake.host};
  std::string text{"GET " + handshake.target + " HTTP/1.1\r\nHost: " + host +
                   "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"};
  if (!handshake.subprotocols.empty()) text += "Sec-WebSocket-Protocol: " + handshake.subprotocols + "\r\n";
  return ask(wire, text + handshake.fields + "\r\n");
}

}  // namespace

int Received::close_code() const {
  return bytes.size() < 2 ? 0 : static_cast<int>(big_endian(std::string_view{bytes}.substr(0, 2)));
}

Client::Client(std::uint16_t port, const Handshake& handshake, int receive_buffer)
    : wire_{port, receive_buffer}, accepted_{shake_hands(wire_, port, handshake)} {
  if (accepted_.status != 101) throw std::runtime_error{"refused: " + accepted_.body};
  rest_ = std::move(accepted_.body);
}

HttpAnswer refusal(std::uint16_t port, const Handshake& handshake) {
  return shake_hands(Wire{port}, port, handshake);
}

void Client::send_frame(int opcode, std::string_view bytes, bool final) const {
  std::string frame{static_cast<char>((final ? 0x80 : 0) | opcode)};
  const int length_bytes{bytes.size() < 126 ? 0 : bytes.size() < 65536 ? 2 : 8};
  const std::size_t short_length{length_bytes == 0 ? bytes.size() : length_bytes == 2 ? 126U : 127U};
  frame.push_back(static_cast<char>(0x80 | short_length));
  for (int i{length_bytes - 1}; i >= 0; --i) frame.push_back(static_cast<char>(bytes.size() >> (8 * i) & 0xff));
  const std::string mask{"\x11\x22\x33\x44"};
  frame += mask;
  for (std::size_t i{0}; i < bytes.size(); ++i) frame.push_back(static_cast<char>(bytes[i] ^ mask[i % 4]));
  wire_.send(frame);
}

Received Client::receive(std::chrono::milliseconds time) {
  const auto have{[&](std::size_t count) {
    while (rest_.size() < count) {
      const std::string more{wire_.receive(time)};
      if (more.empty()) return false;
      rest_ += more;
    }
    return true;
  }};
  for (;;) {
    if (!have(2)) return {};
    const int short_length{static_cast<unsigned char>(rest_[1])};
    const std::size_t length_bytes{short_length < 126 ? 0U : short_length == 126 ? 2U : 8U};
    if (!have(2 + length_bytes)) return {};
    const std::size_t length{length_bytes == 0 ? static_cast<std::size_t>(short_length)
                                               : big_endian(std::string_view{rest_}.substr(2, length_bytes))};
    if (!have(2 + length_bytes + length)) return {};
    const Received received{rest_[0] & 0x0f, rest_.substr(2 + length_bytes, length)};
    rest_.erase(0, 2 + length_bytes + length);
    if (received.opcode != 9) return received;
    send_frame(10, received.bytes);
  }
}

Json Client::expect(const std::string& op) {
  for (;;) {
    const Received received{receive()};
    if (received.opcode == 0 || received.opcode == 8) throw std::runtime_error{"no message '" + op + "' came"};
    if (received.opcode != 1) continue;
    Json message(Json::parse(received.bytes));
    if (message.at("op") == op) return message;
  }
}

std::string Client::expect_binary() {
  for (;;) {
    const Received received{receive()};
    if (received.opcode == 0 || received.opcode == 8) throw std::runtime_error{"no binary message came"};
    if (received.opcode == 2) return received.bytes;
  }
}

int Client::expect_close() {
  for (;;) {
    const Received received{receive()};
    if (received.opcode == 8) return received.close_code();
    if (received.opcode == 0) return 0;
  }
}

ServerOptions options(const Limits& limits) {
  ServerOptions options;
  options.port = 0;
  options.limits = limits;
  return options;
}

Channel grid_channel(const std::string& topic) {
  Channel channel;
  channel.topic = topic;
  channel.schema_name = "nav_msgs/msg/OccupancyGrid";
  channel.schema = "int8[] data";
  return channel;
}

void send(Server& server, ChannelId channel, std::uint64_t stamp_ns, std::string_view bytes) {
  server.send(channel, stamp_ns, std::as_bytes(std::span{bytes}));
}

Data data_of(const std::string& bytes) {
  if (bytes.size() < 13) throw std::runtime_error{"a message of " + std::to_string(bytes.size()) + " bytes"};
  const std::string_view view{bytes};
  return {bytes[0], static_cast<std::uint32_t>(little_endian(view.substr(1, 4))), little_endian(view.substr(5, 8)),
          bytes.substr(13)};
}

void subscribe(Server& server, Client& client, ChannelId channel) {
  client.send({{"op", "subscribe"}, {"subscriptions", {{{"id", channel}, {"channelId", channel}}}}});
  // its answer comes after the subscription
  client.send({{"op", "subscribeConnectionGraph"}});
  client.expect("connectionGraphUpdate");
  client.send({{"op", "unsubscribeConnectionGraph"}});
  if (!server.wanted(channel)) throw std::runtime_error{"the subscription is not known"};
}

bool soon(const std::function<bool()>& fact, std::chrono::milliseconds time) {
  for (const auto end{std::chrono::steady_clock::now() + time}; std::chrono::steady_clock::now() < end;) {
    if (fact()) return true;
    std::this_thread::sleep_for(2ms);
  }
  return fact();
}

}  // namespace stereogrid::server::testing
