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

}  // namespace stereogrid::server::testing
