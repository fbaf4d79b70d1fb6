// SPDX-License-Identifier: Apache-2.0
//
// Latency of grids of 400 × 400 cells (int8, 30 a second) at clients on the same machine, from the call of send() to
// the last byte read, and memory of the server. Clients: 1, 8 and 50, and one more that reads nothing. Argument:
// seconds for each, default 10. One thread reads for all clients, on the same processors.
#include <arpa/inet.h>
#include <malloc.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "stereogrid/server/server.hpp"

namespace {

using namespace stereogrid::server;
using Clock = std::chrono::steady_clock;

constexpr std::size_t grid_bytes{400 * 400};
constexpr std::size_t head_bytes{1 + 4 + 8};                      // operation, subscription, stamp
constexpr std::size_t frame_bytes{10 + head_bytes + grid_bytes};  // with the WebSocket's own head for this length
constexpr std::chrono::nanoseconds period{33'333'333};

std::uint64_t now_ns() {
  return static_cast<std::uint64_t>(Clock::now().time_since_epoch().count());
}

/// A client that subscribes to channel 1.
class Viewer {
 public:
  explicit Viewer(std::uint16_t port) : socket_{::socket(AF_INET, SOCK_STREAM, 0)} {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0) {
      throw std::runtime_error{"cannot connect"};
    }
    say("GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: "
        "13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n");
    std::string answer;
    while (answer.find("\r\n\r\n") == std::string::npos && answer.size() < 4096) {
      char byte{0};
      if (::recv(socket_, &byte, 1, 0) != 1) break;
      answer.push_back(byte);
    }
    if (answer.find(" 101 ") == std::string::npos) throw std::runtime_error{"refused: " + answer};
    const std::string request{R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]})"};
    say(std::string{"\x81"} + static_cast<char>(0x80 | request.size()) + std::string(4, '\0') + request);  // mask 0
  }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;
  ~Viewer() { ::close(socket_); }

  [[nodiscard]] int socket() const { return socket_; }

  /// Reads available data; appends the latency of each completed grid, ms.
  void read(std::vector<double>& latencies_ms) {
    const ssize_t count{::recv(socket_, buffer_.data() + filled_, buffer_.size() - filled_, MSG_DONTWAIT)};
    if (count <= 0) return;
    filled_ += static_cast<std::size_t>(count);
    std::size_t start{0};
    for (std::size_t size{frame_size(start)}; size > 0 && filled_ - start >= size; size = frame_size(start)) {
      if (size == frame_bytes) {
        std::uint64_t stamp_ns{0};
        std::memcpy(&stamp_ns, buffer_.data() + start + 10 + 5, sizeof stamp_ns);
        latencies_ms.push_back(static_cast<double>(now_ns() - stamp_ns) * 1e-6);
      }
      start += size;
    }
    std::memmove(buffer_.data(), buffer_.data() + start, filled_ - start);
    filled_ -= start;
  }

 private:
  void say(const std::string& bytes) const {
    if (::send(socket_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
      throw std::runtime_error{"cannot send"};
    }
  }

  /// With its head; 0: the head is not there yet.
  [[nodiscard]] std::size_t frame_size(std::size_t start) const {
    const auto byte{
        [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(buffer_[start + i])); }};
    if (filled_ - start < 10) return 0;
    if (byte(1) < 126) return 2 + byte(1);
    if (byte(1) == 126) return 4 + (byte(2) << 8 | byte(3));
    return 10 + (byte(7) << 16 | byte(8) << 8 | byte(9));
  }

  int socket_;
  std::string buffer_ = std::string(2 * frame_bytes, '\0');
  std::size_t filled_{0};
};

/// Reads for all viewers until stopped.
std::vector<double> latencies_of(std::vector<std::unique_ptr<Viewer>>& viewers, const std::atomic<bool>& stop) {
  std::vector<double> latencies_ms;
  std::vector<pollfd> sockets;
  for (const auto& viewer : viewers) sockets.push_back({viewer->socket(), POLLIN, 0});
  while (!stop) {
    ::poll(sockets.data(), sockets.size(), 20);
    for (std::size_t i{0}; i < viewers.size(); ++i) {
      if (sockets[i].revents != 0) viewers[i]->read(latencies_ms);
    }
  }
  return latencies_ms;
}

/// Sends at the pace of a camera; how long each call of send() took, in µs.
std::vector<double> send_grids(Server& server, ChannelId channel, std::chrono::seconds time) {
  const std::vector<std::byte> grid(grid_bytes);
  std::vector<double> calls_us;
  const auto end{Clock::now() + time};
  for (auto next{Clock::now()}; next < end; next += period) {
    std::this_thread::sleep_until(next);
    const std::uint64_t start_ns{now_ns()};
    server.send(channel, start_ns, grid);
    calls_us.push_back(static_cast<double>(now_ns() - start_ns) * 1e-3);
  }
  return calls_us;
}

/// Sorts.
double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

/// Heap memory of this process, MB.
double heap_mb() {
  const auto use{mallinfo2()};
  return static_cast<double>(use.uordblks + use.hblkhd) * 1e-6;
}

void measure(int clients, bool stalled, std::chrono::seconds time) {
  const double before_mb{heap_mb()};
  ServerOptions options;
  options.port = 0;
  Server server{options};
  Channel channel;
  channel.topic = "/grid";
  const ChannelId id{server.add_channel(channel)};
  std::vector<std::unique_ptr<Viewer>> viewers;
  for (int i{0}; i < clients; ++i) viewers.push_back(std::make_unique<Viewer>(server.port()));
  std::unique_ptr<Viewer> silent;
  if (stalled) silent = std::make_unique<Viewer>(server.port());
  std::this_thread::sleep_for(std::chrono::milliseconds{200});  // until all subscribe

  std::atomic<bool> stop{false};
  std::vector<double> latencies_ms;
  std::thread reader{[&] { latencies_ms = latencies_of(viewers, stop); }};
  std::vector<double> calls_us{send_grids(server, id, time)};
  const double of_viewers_mb{static_cast<double>(viewers.size() + (silent ? 1 : 0)) * 2e-6 * frame_bytes};
  const double memory_mb{heap_mb() - before_mb - of_viewers_mb};
  std::this_thread::sleep_for(std::chrono::milliseconds{500});
  stop = true;
  reader.join();
  std::printf("| %d | %d | %.0f | %.1f | %.2f | %.2f | %.2f | %.0f | %llu | %.1f |\n", clients, stalled ? 1 : 0,
              static_cast<double>(latencies_ms.size()) / static_cast<double>(time.count()),
              100.0 * static_cast<double>(latencies_ms.size()) / static_cast<double>(calls_us.size() * viewers.size()),
              quantile(latencies_ms, 0.5), quantile(latencies_ms, 0.99), quantile(latencies_ms, 1.0),
              quantile(calls_us, 0.99), static_cast<unsigned long long>(server.counts().messages_dropped), memory_mb);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::chrono::seconds time{std::max(1, argc > 1 ? std::atoi(argv[1]) : 10)};
    std::printf(
        "| clients | stalled ones | messages/s | received %% | p50 ms | p99 ms | most ms | p99 of send() µs | dropped "
        "| server's memory, MB |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const int clients : {1, 8, 50}) {
      for (const bool stalled : {false, true}) measure(clients, stalled, time);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_server: %s\n", error.what());
    return 75;
  }
  return 0;
}
