// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

#include <zlib.h>

#include <ostream>

namespace stereogrid::mcap::testing {

void put(const fs::path& path, std::string_view bytes) {
  fs::remove(path);
  io::testing::put(path, bytes);
}

std::string number(std::uint64_t value, int bytes) {
  std::string text;
  for (int i{0}; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

std::string text(std::string_view text) {
  return number(text.size(), 4) + std::string{text};
}

std::string record(int op, std::string_view content) {
  return number(static_cast<std::uint64_t>(op), 1) + number(content.size(), 8) + std::string{content};
}

std::string message_record(int channel, int sequence, std::uint64_t log_ns, std::uint64_t publish_ns,
                           std::string_view data) {
  return record(5, number(static_cast<std::uint64_t>(channel), 2) + number(static_cast<std::uint64_t>(sequence), 4) +
                       number(log_ns, 8) + number(publish_ns, 8) + std::string{data});
}

std::uint32_t crc(std::string_view bytes) {
  const auto* const data{reinterpret_cast<const Bytef*>(bytes.data())};
  return static_cast<std::uint32_t>(::crc32(0, data, static_cast<uInt>(bytes.size())));
}

std::string string_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::ostream& operator<<(std::ostream& out, const Said& said) {
  return out << said.topic << " #" << said.sequence << " at " << said.log_ns << ": " << said.data.size() << " bytes";
}

std::vector<Said> random_messages(unsigned seed, int count, std::uint64_t step_ns) {
  std::mt19937 random{seed};
  std::vector<Said> messages;
  for (int i{0}; i < count; ++i) {
    Said said;
    said.topic = std::vector<std::string>{"/a", "/b", "/c"}[random() % 3];
    said.sequence = static_cast<std::uint32_t>(i);
    said.log_ns = 1'000'000'000'000 + static_cast<std::uint64_t>(i) * step_ns + random() % 1'000'000'000;
    said.publish_ns = said.log_ns - random() % 1'000;
    said.data.assign(random() % 8 == 0 ? random() % 5000 : random() % 50, '\0');
    for (char& byte : said.data) byte = static_cast<char>(random() % 3);
    messages.push_back(std::move(said));
  }
  return messages;
}

void write_messages(const fs::path& path, const std::vector<Said>& messages, const WriterOptions& options) {
  Writer writer{path, options};
  std::map<std::string, std::uint16_t> channels;
  const std::uint16_t text_schema{writer.add_schema("std_msgs/msg/String", "ros2msg", "string data\n")};
  const std::uint16_t number_schema{writer.add_schema("std_msgs/msg/Int8", "ros2msg", "int8 data\n")};
  for (const char* const topic : {"/a", "/b", "/c"}) {
    channels[topic] = writer.add_channel(topic, "cdr", topic[1] == 'c' ? number_schema : text_schema,
                                         {{"offered_qos_profiles", offered_qos_profiles({})}});
  }
  for (const Said& said : messages) {
    writer.write(channels.at(said.topic), said.sequence, said.log_ns, said.publish_ns, bytes_of(said.data));
  }
  writer.close();
}

std::vector<Said> read_all(const Reader& reader, const Selection& selection) {
  std::vector<Said> all;
  const auto cursor{reader.messages(selection)};
  while (const Message* const message{cursor->next()}) {
    all.push_back({reader.contents().channels.at(message->channel).topic, message->sequence, message->log_time_ns,
                   message->publish_time_ns, string_of(message->data)});
  }
  return all;
}

std::pair<std::vector<Said>, Damage> stream_all(const fs::path& path) {
  std::vector<Said> all;
  StreamReader reader{path};
  while (const Message* const message{reader.next()}) {
    all.push_back({reader.contents().channels.at(message->channel).topic, message->sequence, message->log_time_ns,
                   message->publish_time_ns, string_of(message->data)});
  }
  return {all, reader.damage()};
}

std::vector<Said> in_time(std::vector<Said> messages) {
  std::ranges::stable_sort(messages, {}, &Said::log_ns);
  return messages;
}

}  // namespace stereogrid::mcap::testing
