// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "foxglove/message_queue.hpp"
#include "foxglove/protocol.hpp"
#include "stereogrid/server/server.hpp"

namespace stereogrid::server {

/// Reasons to close a WebSocket (RFC 6455, 7.4.1, and its registry).
namespace close_code {
inline constexpr std::uint16_t going_away{1001};
inline constexpr std::uint16_t policy{1008};
inline constexpr std::uint16_t try_again_later{1013};
}  // namespace close_code

/// A client's connection, as the protocol sees it. Its functions return at once and do not call back.
class Link {
 public:
  Link() = default;
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  virtual ~Link() = default;

  /// There is something to send: to be fetched with Hub::next() when it can be written.
  virtual void wake() = 0;
  virtual void close(std::uint16_t code, const std::string& reason) = 0;
};

/// Content of one WebSocket message: the head, then the payload of the message, if there is one.
struct Frame {
  bool binary;
  std::string head;
  SharedMessage message;
};

/// An amount per second on average, twice as much at once: requests, or their bytes.
class RequestRate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit RequestRate(int per_second) : per_second_{static_cast<double>(per_second)}, left_{2 * per_second_} {}
  /// False: too much.
  [[nodiscard]] bool take(Time now, double amount = 1);

 private:
  double per_second_;
  double left_;
  Time last_{};
};

/// State of a client. Content that newer content may replace (the time, the graph, parameters) is not
/// queued as text: it is marked as due, and written as it is when the client can take it.
struct Client {
  Client(Link& its_link, std::string its_name, const Limits& limits)
      : link{its_link},
        name{std::move(its_name)},
        messages{{limits.queue_bytes, limits.queue_messages}},
        rate{limits.requests_per_second},
        byte_rate{limits.request_bytes_per_second} {}

  Link& link;
  std::string name;  ///< in the connection graph
  std::map<SubscriptionId, ChannelId> subscriptions;
  std::map<ChannelId, SubscriptionId> channels;  ///< the same, the other way round
  std::set<std::string> watched_parameters;
  bool watches_graph{false};

  std::deque<std::string> control;
  std::size_t control_bytes{0};
  std::optional<std::uint64_t> time_due;
  bool graph_due{false};
  std::set<std::string> removed_topics;  ///< to be sent with the graph
  std::set<std::string> parameters_due;
  MessageQueue messages;

  RequestRate rate;
  RequestRate byte_rate;
  int faults{0};
  bool closed{false};
};

/// The parameters' present values.
class ParameterStore {
 public:
  /// Throws ConfigError: a name that is empty or there twice, a number that is not finite.
  explicit ParameterStore(Parameters parameters);

  [[nodiscard]] std::size_t size() const { return parameters_.size(); }
  /// None: there is no such parameter.
  [[nodiscard]] const Parameter* find(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> names() const;

  /// A client's value, in a type that JSON has. Returns the reason to reject it; none: the parameter has this value
  /// now.
  [[nodiscard]] std::optional<std::string> set(const Parameter& requested);
  /// The owner's word. Throws ConfigError; see check().
  void put(const Parameter& parameter);
  /// Throws ConfigError: no such parameter, another type, a number that is not finite. Reads what never changes.
  void check(const Parameter& parameter) const;

 private:
  std::map<std::string, Parameter> parameters_;
  std::map<std::string, std::size_t> types_;  ///< which of ParameterValue's; never changes, so that any thread may look
  std::function<std::optional<std::string>(const Parameter&)> set_;
};

/// Identifier of a connected client; never used twice.
using ClientId = std::uint64_t;

struct HubOptions {
  std::string name;
  std::string session;  ///< another one for each server that was started
  bool sends_time{false};
  Parameters parameters;
  Limits limits;
};

/// The Foxglove WebSocket protocol: channels, parameters and clients, without a network. For one thread.
class Hub {
 public:
  /// Throws ConfigError as ParameterStore does.
  Hub(HubOptions options, Inbox& inbox, Counters& counters);

  void add_channel(ChannelId id, Channel channel);
  void remove_channel(ChannelId id);
  /// Hands out what waits in the inbox.
  void publish_all();
  void publish_time(std::uint64_t stamp_ns);
  void publish_status(StatusLevel level, std::string_view text);
  void put_parameter(const Parameter& parameter);
  [[nodiscard]] const ParameterStore& parameters() const { return parameters_; }

  /// The link has to stay until leave().
  ClientId join(Link& link);
  void leave(ClientId id);
  void receive(ClientId id, std::string_view bytes, bool binary, RequestRate::Time now);
  /// Next frame to write to this client; none: nothing, until it is woken.
  [[nodiscard]] std::optional<Frame> next(ClientId id);

 private:
  struct Stream {
    Channel channel;
    std::set<ClientId> subscribers;
    SharedMessage last;  ///< last message of a latched channel
  };

  void handle(ClientId id, const Subscribe& request);
  void handle(ClientId id, const Unsubscribe& request);
  void handle(ClientId id, const GetParameters& request);
  void handle(ClientId id, const SetParameters& request);
  void handle(ClientId id, const SubscribeParameters& request);
  void handle(ClientId id, const UnsubscribeParameters& request);
  void handle(ClientId id, SubscribeGraph request);
  void handle(ClientId id, UnsubscribeGraph request);

  /// Returns why not.
  std::optional<std::string> subscribe(ClientId id, const Subscription& wanted);
  void unsubscribe(Client& client, ClientId id, SubscriptionId subscription);
  void publish(const SharedMessage& message);
  void push(Client& client, const SharedMessage& message);
  /// One sentence for what may be many.
  void report_status(Client& client, StatusLevel level, const std::string& first, std::size_t count);
  void send_control(Client& client, std::string text);
  void close(Client& client, const std::string& reason);
  void graph_changed(const std::string& removed_topic = {});
  void parameter_changed(const std::string& name);
  void notify_subscribers(ChannelId id);
  [[nodiscard]] std::string graph_text(Client& client) const;
  [[nodiscard]] std::string parameters_text(const std::set<std::string>& names,
                                            const std::optional<std::string>& request) const;

  HubOptions options_;
  Inbox& inbox_;
  Counters& counters_;
  ParameterStore parameters_;
  std::map<ChannelId, Stream> streams_;
  std::map<ChannelId, SharedMessage> early_;  ///< last messages of channels that are still to be added
  std::map<ClientId, Client> clients_;
  ClientId last_client_{0};
};

}  // namespace stereogrid::server
