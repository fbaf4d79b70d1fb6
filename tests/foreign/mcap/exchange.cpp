// SPDX-License-Identifier: Apache-2.0
//
// Usage: mcap_exchange write FILE none|lz4|zstd, or mcap_exchange read FILE. Prints each message as a line, in the
// order of log times: topic, type, what describes the type, offered QoS, sequence, log and publish time in ns, data in
// hexadecimal; tabs between them.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/mcap/reader.hpp"
#include "stereogrid/mcap/writer.hpp"

namespace {

using namespace stereogrid::mcap;

Compression compression_of(std::string_view name) {
  return name == "zstd" ? Compression::zstd : name == "lz4" ? Compression::lz4 : Compression::none;
}

/// Two seconds of messages, not in the order of their times, in many chunks.
void write(const char* file, std::string_view compression) {
  Writer writer{file, {.compression = compression_of(compression), .chunk_bytes = 10'000, .library = "stereogrid ü"}};
  const auto schema{writer.add_schema("std_msgs/msg/String", "ros2msg", "string data\n")};
  std::vector<std::uint16_t> channels;
  for (const char* const topic : {"/a", "/b/c", "/never"}) {
    channels.push_back(writer.add_channel(topic, "cdr", schema, {{"offered_qos_profiles", offered_qos_profiles({})}}));
  }
  writer.write_metadata("run", {{"preset", "default"}, {"empty", ""}});
  std::mt19937 random{1};
  for (std::uint32_t i{0}; i < 2000; ++i) {
    std::vector<std::byte> data(random() % 300);
    for (std::byte& byte : data) byte = static_cast<std::byte>(random() % 4);
    const std::uint64_t time{1'700'000'000'000'000'000 + i * 1'000'000ULL + random() % 50'000'000};
    writer.write(channels[random() % 2], i, time, time - random() % 1000, data);
  }
  writer.close();
}

std::string hexadecimal(std::span<const std::byte> bytes) {
  constexpr std::string_view digits{"0123456789abcdef"};
  std::string text;
  for (const std::byte byte : bytes) {
    text += digits[static_cast<std::size_t>(byte) >> 4];
    text += digits[static_cast<std::size_t>(byte) & 15];
  }
  return text;
}

void read(const char* file) {
  const Reader reader{file};
  const auto cursor{reader.messages()};
  while (const Message* const message{cursor->next()}) {
    const Channel& channel{reader.contents().channels.at(message->channel)};
    const Schema& schema{reader.contents().schemas.at(channel.schema_id)};
    std::string qos{channel.metadata.at("offered_qos_profiles")};
    std::ranges::replace(qos, '\n', '|');
    std::printf("%s\t%s\t%zu\t%s\t%u\t%llu\t%llu\t%s\n", channel.topic.c_str(), schema.name.c_str(), schema.data.size(),
                qos.c_str(), message->sequence, static_cast<unsigned long long>(message->log_time_ns),
                static_cast<unsigned long long>(message->publish_time_ns), hexadecimal(message->data).c_str());
  }
  for (const std::string& sentence : reader.damage().sentences) std::printf("damage\t%s\n", sentence.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view command{argc >= 3 ? argv[1] : ""};
  try {
    if (command == "write" && argc == 4) write(argv[2], argv[3]);
    if (!command.empty()) read(argv[2]);
    return command.empty() ? 64 : 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
