// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::server::testing {
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

ServerOptions options() {
  ServerOptions options;
  options.port = 0;
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
