// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/server/http.hpp"

namespace stereogrid::server {

/// Identifier of a channel, as clients see it; never used twice by one server.
using ChannelId = std::uint32_t;

/// A stream of messages that clients can subscribe to.
struct Channel {
  std::string topic;
  std::string encoding{"cdr"};  ///< encoding of its messages
  std::string schema_name;      ///< such as nav_msgs/msg/OccupancyGrid
  std::string schema;           ///< the definition as text, with those of the types within it
  std::string schema_encoding{"ros2msg"};
  /// The last message is kept, even without subscribers, and sent to a new subscriber at once.
  bool latched{false};
};

using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<bool>,
                                    std::vector<std::int64_t>, std::vector<double>, std::vector<std::string>>;

struct Parameter {
  std::string name;
  ParameterValue value;  ///< its type stays; numbers are finite
};

/// Parameters that clients can read and set.
struct Parameters {
  std::vector<Parameter> values;  ///< names are unique
  /// Called for a client's new value, of the parameter's type. Returns the reason to reject it; none: it is accepted.
  /// Runs on the server's thread, which serves no client meanwhile: it should be quick, and what it shares with other
  /// threads is the owner's to guard. An exception counts as a refusal with its text. None at all: clients can only
  /// read.
  std::function<std::optional<std::string>(const Parameter&)> set;
};

/// Limits that no client can make the server exceed.
struct Limits {
  std::size_t clients{64};                           ///< WebSockets at a time
  std::size_t connections{256};                      ///< connections of any kind at a time
  std::size_t connections_per_address{128};          ///< connections from one address
  std::size_t queue_bytes{std::size_t{32} << 20};    ///< waiting for a client; a single larger message still goes out
  std::size_t queue_messages{16};                    ///< messages of each channel, waiting for a client
  std::size_t control_bytes{std::size_t{4} << 20};   ///< replies waiting; a client that leaves more unread is closed
  std::size_t request_bytes{std::size_t{64} << 10};  ///< size of a client's message
  int requests_per_second{100};                      ///< average rate of a client; twice as many at once
  int request_bytes_per_second{256 << 10};           ///< average rate of a client's messages; twice as many at once
  int faults{20};                                    ///< malformed requests before a client is closed
  std::chrono::milliseconds http_timeout{10'000};    ///< for a whole request, and each 64 KiB of a reply
  std::chrono::milliseconds idle_timeout{30'000};    ///< for any sign of life of a WebSocket client, which is pinged
};

struct ServerOptions {
  std::string name{"stereogrid"};  ///< for clients to show
  /// Address of this machine, IPv4 or IPv6, or "localhost"; "0.0.0.0", "::": all of them.
  std::string address{"127.0.0.1"};
  std::uint16_t port{8765};  ///< 0: any free one
  /// Secret that clients have to send, of 22 or more letters, digits, '-' and '_'. Empty: none where the address is a
  /// loopback address; any other gets one made up, of 160 random bits.
  std::string token;
  /// Pages of other sites that may open a WebSocket, such as https://app.foxglove.dev; as the browser's header Origin
  /// says it. This server's own pages, and programs that are no browser, always may.
  std::vector<std::string> allowed_origins;
  bool sends_time{false};  ///< send_time() will be used: clients then go by it, not by their own clock
  Parameters parameters;
  HttpContent http;
  Limits limits;
};

enum class StatusLevel { info = 0, warning = 1, error = 2 };

/// Since the server was made, and at present.
struct ServerCounts {
  std::size_t clients{0};  ///< WebSockets now
  std::uint64_t clients_ever{0};
  std::uint64_t messages_sent{0};     ///< to each client
  std::uint64_t bytes_sent{0};        ///< bytes of these messages
  std::uint64_t messages_dropped{0};  ///< for clients that were too slow, or where the server itself was
  std::uint64_t faults{0};            ///< malformed requests of clients
  std::uint64_t refused{0};           ///< requests and clients turned away: host, origin, token, sub-protocol, limits
  std::uint64_t http_requests{0};
};

/// One port for HTTP and for WebSocket clients of the Foxglove protocol (sub-protocols foxglove.websocket.v1 and
/// foxglove.sdk.v1, github.com/foxglove/ws-protocol), served by one thread of its own. All functions may be called from
/// any thread, from the callbacks too, and never wait for a client.
class STEREOGRID_EXPORT Server {
 public:
  /// Listens. Throws ConfigError: an option that cannot work; DeviceError: the port is taken or may not be used.
  explicit Server(ServerOptions options);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  /// Sends clients the close code "going away", waits a second at most for them, and for a callback that is running.
  ~Server();

  [[nodiscard]] std::uint16_t port() const;        ///< port of the listening socket
  [[nodiscard]] const std::string& token() const;  ///< empty: none is needed
  /// To be opened in a browser, with the token: http://127.0.0.1:8765/?token=…
  [[nodiscard]] const std::string& url() const;

  ChannelId add_channel(Channel channel);
  /// Messages sent to it from now on are ignored.
  void remove_channel(ChannelId id);
  /// Whether a message would be of use: the channel has a subscriber or is latched.
  [[nodiscard]] bool wanted(ChannelId id) const;
  /// Sends a message to all subscribers. It is copied once; without subscribers, not at all. A client that is slow
  /// loses the oldest messages of the channel.
  void send(ChannelId id, std::uint64_t stamp_ns, std::span<const std::byte> message);
  /// The time that clients should go by, such as that of a recording. Needs ServerOptions::sends_time.
  void send_time(std::uint64_t stamp_ns);
  /// Text for all clients that are connected now.
  void send_status(StatusLevel level, std::string_view text);
  /// A parameter has another value now; does not call Parameters::set. Throws ConfigError: no such parameter, another
  /// type, or a number that is not finite.
  void set_parameter(const Parameter& parameter);

  [[nodiscard]] ServerCounts counts() const;

 private:
  struct STEREOGRID_HIDDEN State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::server
