// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <nlohmann/json.hpp>

#include "foxglove/hub.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

using namespace stereogrid::server;

class SilentLink : public Link {
 public:
  void wake() override { woken = true; }
  void close(std::uint16_t, const std::string& reason) override {
    require(!closed, "closed twice");
    require(!reason.empty(), "closed without a reason");
    closed = true;
  }

  bool woken{false};
  bool closed{false};
};

HubOptions some_options() {
  HubOptions options;
  options.name = "fuzz";
  options.sends_time = true;
  options.parameters.values = {{"b", true},
                               {"i", std::int64_t{1}},
                               {"d", 1.0},
                               {"s", std::string{"x"}},
                               {"bs", std::vector<bool>{true}},
                               {"is", std::vector<std::int64_t>{1}},
                               {"ds", std::vector<double>{1}},
                               {"ss", std::vector<std::string>{"x"}}};
  options.parameters.set = [](const Parameter& requested) {
    return requested.name == "s" ? std::optional<std::string>{"not this one"} : std::nullopt;
  };
  options.limits.control_bytes = std::size_t{1} << 16;
  return options;
}

Channel channel(const char* topic, bool latched) {
  Channel made;
  made.topic = topic;
  made.latched = latched;
  return made;
}

void check(const Frame& frame) {
  if (frame.binary) return require(frame.head.size() == (frame.message ? 13 : 9), "a binary head of another size");
  const nlohmann::json message(nlohmann::json::parse(frame.head));
  require(message.at("op").is_string() && !frame.message, "a text message without operation");
}

/// A hub with two channels and two clients.
struct Room {
  Room() {
    for (const ChannelId id : {1U, 2U}) {
      inbox.open(id, id == 2);
      hub.add_channel(id, channel(id == 1 ? "/a" : "/b", id == 2));
    }
    other = hub.join(other_link);
    client = hub.join(link);
  }

  void publish(std::uint64_t stamp_ns) {
    for (const ChannelId id : {1U, 2U}) {
      const bool notified{
          inbox.put(std::make_shared<const Message>(Message{id, stamp_ns, std::vector<std::byte>(20)}))};
      require(notified == (id == 1), "the inbox was not emptied");
    }
    hub.publish_all();
    hub.publish_time(stamp_ns);
  }

  void drain(ClientId id) {
    while (const auto frame{hub.next(id)}) check(*frame);
  }

  Counters counters;
  Inbox inbox{{1 << 16, 4}, counters};
  Hub hub{some_options(), inbox, counters};
  SilentLink link;
  SilentLink other_link;
  ClientId client{0};
  ClientId other{0};
};

}  // namespace

/// Messages of a WebSocket client, separated as files are; binary: after a 'b'.
FUZZ_TARGET(foxglove_client) {
  Room room;
  RequestRate::Time now{std::chrono::seconds{1}};
  for (const std::string_view message : parts_of(input, 24)) {
    const bool binary{message.starts_with('b')};
    room.hub.receive(room.client, binary ? message.substr(1) : message, binary, now);
    room.publish(static_cast<std::uint64_t>(now.time_since_epoch().count()));
    if (message.size() % 3 != 0) room.drain(room.client);  // sometimes it is slow
    now += std::chrono::milliseconds{20};
  }
  room.drain(room.client);
  room.drain(room.other);
  room.hub.leave(room.client);
  require(!room.inbox.wanted(1), "a client that has gone subscribes");
  require(!room.other_link.closed, "another client was closed");
}

}  // namespace stereogrid::fuzz
