// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/mcap/reader.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

/// Reads every byte; returns the number of messages.
std::uint64_t drain(mcap::MessageCursor& cursor) {
  std::uint64_t messages{0};
  for (; const mcap::Message* const message{cursor.next()}; ++messages) {
    std::uint64_t sum{0};
    for (const std::byte byte : message->data) sum += static_cast<std::uint64_t>(byte);
    require(sum <= 255 * message->data.size(), "bytes of more than 255");
  }
  return messages;
}

void drain(const mcap::Bag& bag) {
  const auto cursor{bag.messages({})};
  std::uint64_t last_ns{0};
  while (const mcap::Message* const message{cursor->next()}) {
    require(message->channel < bag.topics().size(), "a message of no topic");
    require(message->log_time_ns >= last_ns, "messages not in the order of time");
    last_ns = message->log_time_ns;
  }
}

}  // namespace

FUZZ_TARGET(mcap) {
  static const Folder folder;
  const auto file{folder.write("a.mcap", text_of(input))};
  accepts([&] {
    mcap::StreamReader stream{file};
    const std::uint64_t messages{drain(stream)};
    std::uint64_t counted{0};
    for (const auto& [channel, count] : stream.contents().message_counts) counted += count;
    require(counted == messages, "a stream counts other messages than it gives");
    const mcap::Reader reader{file};
    drain(*reader.messages());
    require(reader.is_indexed() || reader.damage().any() == stream.damage().any(), "what is damaged is not reported");
  });
}

FUZZ_TARGET(bag_db3) {
  static const Folder folder;
  const auto file{folder.write("a.db3", text_of(input))};
  accepts([&] { drain(*mcap::open_bag(file)); });
}

/// File metadata.yaml of a bag without parts.
FUZZ_TARGET(bag_metadata) {
  static const Folder folder;
  folder.write("metadata.yaml", text_of(input));
  accepts([&] { drain(*mcap::open_bag(folder.path())); });
}

}  // namespace stereogrid::fuzz
