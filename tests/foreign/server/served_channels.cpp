// SPDX-License-Identifier: Apache-2.0
//
// A server with some channels and parameters; prints its port, and ends when its standard input does.
#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <thread>

#include "stereogrid/server/server.hpp"

namespace {

using namespace stereogrid::server;

Channel channel(const char* topic, bool latched) {
  Channel made;
  made.topic = topic;
  made.schema_name = "std_msgs/msg/String";
  made.schema = "string data";
  made.latched = latched;
  return made;
}

void serve() {
  ServerOptions options;
  options.port = 0;
  options.name = "served channels";
  options.sends_time = true;
  options.parameters.values = {{"gain", 1.5}, {"names", std::vector<std::string>{"a", "b"}}};
  options.parameters.set = [](const Parameter&) { return std::nullopt; };
  Server server{options};
  const ChannelId latched{server.add_channel(channel("/latched", true))};
  const ChannelId stream{server.add_channel(channel("/stream", false))};
  const std::string text{"last"};
  server.send(latched, 42, std::as_bytes(std::span{text}));
  std::printf("%d\n", server.port());
  std::fflush(stdout);
  std::jthread sender{[&](const std::stop_token& stop) {
    for (std::uint64_t number{0}; !stop.stop_requested(); ++number) {
      const std::string bytes(1000, static_cast<char>(number));
      server.send(stream, number, std::as_bytes(std::span{bytes}));
      server.send_time(number);
      std::this_thread::sleep_for(std::chrono::milliseconds{10});
    }
  }};
  while (std::getchar() != EOF) {
  }
}

}  // namespace

int main() {
  try {
    serve();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "served_channels: %s\n", error.what());
    return 70;
  }
  return 0;
}
