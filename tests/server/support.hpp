// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "../prelude.hpp"
#include "../temporary_folder.hpp"
#include "stereogrid/server/server.hpp"

// Clients of a socket of their own: nothing here is made of what the server is made of.
namespace stereogrid::server::testing {

using ::testing::AllOf, ::testing::Contains, ::testing::Each, ::testing::ElementsAre, ::testing::HasSubstr,
    ::testing::IsEmpty, ::testing::Not, ::testing::Optional, ::testing::SizeIs, ::testing::StartsWith,
    ::testing::ThrowsMessage;

using namespace std::chrono_literals;
using Json = nlohmann::json;
using tests::TemporaryFolder;

inline constexpr std::chrono::milliseconds patience{10'000};  ///< far more than anything takes

/// A TCP connection to a port of this machine. Throws std::runtime_error where it cannot connect.
class Wire {
 public:
  /// `receive_buffer` > 0: approximate size of the system's receive buffer, bytes. `source`: the client's address.
  explicit Wire(std::uint16_t port, int receive_buffer = 0, const char* address = "127.0.0.1",
                const char* source = nullptr);
  Wire(Wire&& other) noexcept;
  Wire& operator=(Wire&&) = delete;
  ~Wire();

  /// Returns early if the peer accepts no more bytes.
  void send(std::string_view bytes) const;
  /// Receives at least one byte; empty: the peer has closed, or timeout.
  [[nodiscard]] std::string receive(std::chrono::milliseconds time = patience) const;
  /// Receives all until the peer closes. Throws on timeout.
  [[nodiscard]] std::string receive_all(std::chrono::milliseconds time = patience) const;
  /// Closes this side with a reset, as a machine does that has crashed.
  void reset();

 private:
  int socket_;
};

struct HttpAnswer {
  int status{0};
  std::map<std::string, std::string> fields;  ///< names in small letters
  std::string body;
};

/// Sends the bytes and reads one answer of the connection.
HttpAnswer ask(const Wire& wire, const std::string& bytes, bool with_body = true);
/// GET on a connection of its own. `fields`: lines "Name: value\r\n", with Host where it is to be another one.
HttpAnswer get(std::uint16_t port, const std::string& target, const std::string& fields = {},
               const std::string& method = "GET");

struct Received {
  int opcode{0};  ///< 1 text, 2 binary, 8 close; 0: nothing came, or the connection ended
  std::string bytes;

  [[nodiscard]] int close_code() const;
};

struct Handshake {
  std::string subprotocols{"foxglove.sdk.v1"};  ///< empty: no header
  std::string fields{};                         ///< further lines
  std::string target{"/"};
  std::string host{};  ///< empty: 127.0.0.1 and the port
};

/// A WebSocket client.
class Client {
 public:
  /// Throws where the handshake fails; `refusal` below says how.
  explicit Client(std::uint16_t port, const Handshake& handshake = {}, int receive_buffer = 0);

  [[nodiscard]] const HttpAnswer& accepted() const { return accepted_; }
  void send(const Json& message) const { send_frame(1, message.dump()); }
  /// A frame as it is, masked. 1 text, 2 binary, 8 close, 9 ping.
  void send_frame(int opcode, std::string_view bytes, bool final = true) const;
  [[nodiscard]] const Wire& wire() const { return wire_; }
  Wire& wire() { return wire_; }

  /// The next message; answers pings.
  Received receive(std::chrono::milliseconds time = patience);
  /// The next text message with this op; others are passed over. Throws where none comes.
  Json expect(const std::string& op);
  /// The next binary message. Throws where none comes.
  std::string expect_binary();
  /// Until the other side closes: its code; 0: without one.
  int expect_close();

 private:
  Wire wire_;
  std::string rest_;
  HttpAnswer accepted_;
};

HttpAnswer refusal(std::uint16_t port, const Handshake& handshake);

/// Options for a test: any free port.
[[nodiscard]] ServerOptions options(const Limits& limits = {});
[[nodiscard]] Channel grid_channel(const std::string& topic = "/grid");
void send(Server& server, ChannelId channel, std::uint64_t stamp_ns, std::string_view bytes);
/// Message: op, subscription id, stamp and payload.
struct Data {
  int op;
  std::uint32_t subscription;
  std::uint64_t stamp_ns;
  std::string payload;
};
[[nodiscard]] Data data_of(const std::string& bytes);

/// Subscribes with the channel's id as the subscription's, and waits for the server to register it.
void subscribe(Server& server, Client& client, ChannelId channel);

/// Whether it becomes true in time.
[[nodiscard]] bool soon(const std::function<bool()>& fact, std::chrono::milliseconds time = patience);

}  // namespace stereogrid::server::testing
