// SPDX-License-Identifier: Apache-2.0
// Many clients, slow ones, and the end.
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

constexpr std::size_t grid_bytes{400 * 400};

std::string grid(std::uint64_t number) {
  std::string bytes(grid_bytes, static_cast<char>(number));
  bytes.replace(0, 8, reinterpret_cast<const char*>(&number), 8);
  return bytes;
}

std::uint64_t number_of(const std::string& payload) {
  std::uint64_t number{0};
  std::memcpy(&number, payload.data(), sizeof number);
  return number;
}

TEST(Clients, FiftyGetEveryMessage) {
  Server server{options()};
  const ChannelId id{server.add_channel(grid_channel())};
  std::vector<std::unique_ptr<Client>> clients;
  for (int i{0}; i < 50; ++i) {
    clients.push_back(std::make_unique<Client>(server.port()));
    subscribe(server, *clients.back(), id);
  }
  constexpr std::uint64_t count{20};
  for (std::uint64_t number{0}; number < count; ++number) {
    send(server, id, number, grid(number));
    for (const auto& client : clients) {
      const Data data{data_of(client->expect_binary())};
      ASSERT_EQ(data.stamp_ns, number);
      ASSERT_TRUE(data.payload == grid(number));
    }
  }
  EXPECT_EQ(server.counts().clients, 50U);
  EXPECT_EQ(server.counts().messages_sent, 50 * count);
  EXPECT_EQ(server.counts().messages_dropped, 0U);
}

TEST(Clients, AStalledOneLosesTheOldestAndAnotherGetsAll) {
  Server server{options({.queue_messages = 4})};
  const ChannelId id{server.add_channel(grid_channel())};
  Client quick{server.port()};
  Client stalled{server.port(), {}, 65'536};
  subscribe(server, quick, id);
  subscribe(server, stalled, id);
  constexpr std::uint64_t count{300};
  for (std::uint64_t number{0}; number < count; ++number) {
    const auto start{std::chrono::steady_clock::now()};
    send(server, id, number, grid(number));
    EXPECT_LT(std::chrono::steady_clock::now() - start, 5s) << "the sender waited";
    ASSERT_EQ(number_of(data_of(quick.expect_binary()).payload), number);
  }
  const std::uint64_t dropped{server.counts().messages_dropped};
  EXPECT_GT(dropped, 200U);
  std::vector<std::uint64_t> seen;
  while (seen.empty() || seen.back() != count - 1) seen.push_back(number_of(data_of(stalled.expect_binary()).payload));
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_EQ(seen.size() + dropped, count);
  EXPECT_EQ(seen[seen.size() - 4], count - 4) << "the last ones are there";
}

std::size_t resident_bytes() {
  std::ifstream file{"/proc/self/statm"};
  std::size_t all{0};
  std::size_t resident{0};
  file >> all >> resident;
  return resident * 4096;
}

TEST(Clients, StalledOnesTakeABoundedMemory) {
  Server server{options({.queue_bytes = 4 << 20, .queue_messages = 1000})};
  const ChannelId id{server.add_channel(grid_channel())};
  std::vector<std::unique_ptr<Client>> clients;
  for (int i{0}; i < 4; ++i) {
    clients.push_back(std::make_unique<Client>(server.port(), Handshake{}, 65'536));
    subscribe(server, *clients.back(), id);
  }
  const std::size_t before{resident_bytes()};
  for (std::uint64_t number{0}; number < 2000; ++number) send(server, id, number, grid(number));  // 320 MB
  EXPECT_TRUE(soon([&] { return server.counts().messages_dropped > 1500; }));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers keep freed memory
  EXPECT_LT(resident_bytes(), before + (64 << 20));
#else
  static_cast<void>(before);
#endif
}

TEST(Clients, ASlowCallbackDoesNotHoldTheSenderUp) {
  std::atomic<bool> entered{false};
  std::atomic<bool> go_on{false};
  ServerOptions given{options()};
  given.http.endpoints = {{"/slow", [&] {
                             entered = true;
                             while (!go_on) std::this_thread::sleep_for(1ms);
                             return Answer{};
                           }}};
  Server server{given};
  const ChannelId id{server.add_channel(grid_channel())};
  Client client{server.port()};
  subscribe(server, client, id);
  const Wire wire{server.port()};
  wire.send("GET /slow HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(soon([&] { return entered.load(); }));
  for (std::uint64_t number{0}; number < 100; ++number) send(server, id, number, grid(number));
  EXPECT_EQ(server.counts().messages_dropped, 100 - given.limits.queue_messages);
  go_on = true;
  EXPECT_EQ(data_of(client.expect_binary()).stamp_ns, 100 - given.limits.queue_messages);
}

TEST(Clients, FunctionsAreCalledFromManyThreads) {
  ServerOptions given{options()};
  given.parameters.values = {{"a", std::int64_t{0}}};
  Server server{given};
  const ChannelId shared{server.add_channel(grid_channel())};
  Client client{server.port()};
  subscribe(server, client, shared);
  std::atomic<bool> done{false};
  std::thread reader{[&] {
    while (!done) client.receive(10ms);
  }};
  std::vector<std::thread> threads;
  for (int t{0}; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i{0}; i < 100; ++i) {
        const ChannelId own{server.add_channel(grid_channel("/t" + std::to_string(t)))};
        send(server, shared, static_cast<std::uint64_t>(i), "message");
        send(server, own, 1, "nobody");
        server.set_parameter({"a", std::int64_t{i}});
        server.send_time(static_cast<std::uint64_t>(i));
        static_cast<void>(server.counts());
        server.remove_channel(own);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(soon([&] { return server.counts().messages_sent > 0; }));
  done = true;
  reader.join();
}

TEST(End, ClientsAreNotifiedAndPortIsFreeAgain) {
  ServerOptions given{options()};
  std::optional<Server> server{given};
  given.port = server->port();
  const ChannelId id{server->add_channel(grid_channel())};
  Client polite{server->port()};
  subscribe(*server, polite, id);
  Client mute{server->port()};      // does not answer the close
  const Wire idle{server->port()};  // no request
  Client stalled{server->port(), {}, 4096};
  subscribe(*server, stalled, id);
  for (std::uint64_t number{0}; number < 30; ++number) send(*server, id, number, grid(number));
  std::thread reader{[&] {
    EXPECT_EQ(polite.expect_close(), 1001);
    polite.send_frame(8, "\x03\xe9");
  }};
  const auto start{std::chrono::steady_clock::now()};
  server.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 5s);
  reader.join();
  EXPECT_EQ(mute.expect_close(), 1001);
  EXPECT_EQ(idle.receive_all(), "");
  EXPECT_EQ(Server{given}.port(), given.port);
}

/// Time of a server's destructor with clients that answer the close frame.
std::chrono::nanoseconds end_with_polite_clients() {
  std::optional<Server> server{options()};
  std::vector<std::thread> threads;
  for (int i{0}; i < 5; ++i) {
    threads.emplace_back([client = std::make_unique<Client>(server->port())] {
      EXPECT_EQ(client->expect_close(), 1001);
      client->send_frame(8, "\x03\xe9");
      EXPECT_EQ(client->receive().opcode, 0) << "it is the server that closes first";
    });
  }
  EXPECT_TRUE(soon([&] { return server->counts().clients == 5; }));
  const auto start{std::chrono::steady_clock::now()};
  server.reset();
  const auto taken{std::chrono::steady_clock::now() - start};
  for (std::thread& thread : threads) thread.join();
  return taken;
}

TEST(End, WithPoliteClientsItIsQuick) {
  std::chrono::nanoseconds least{end_with_polite_clients()};
  for (int i{0}; i < 5 && least >= 900ms; ++i) least = std::min(least, end_with_polite_clients());  // a busy machine
  EXPECT_LT(least, 900ms) << "nobody had to be waited for";
}

TEST(Listening, APortThatIsTakenIsNamed) {
  const Server server{options()};
  EXPECT_NE(server.port(), 0);
  EXPECT_EQ(server.url(), "http://127.0.0.1:" + std::to_string(server.port()) + "/");
  ServerOptions again{options()};
  again.port = server.port();
  EXPECT_THAT([&] { Server{again}; }, ThrowsMessage<DeviceError>(HasSubstr("Port " + std::to_string(server.port()) +
                                                                           " of 127.0.0.1 is taken")));
}

TEST(Listening, AddressesThatAreNone) {
  for (const char* address : {"", "robot", "1.2.3", "127.0.0.1:80", "192.0.2.1"}) {
    ServerOptions given{options()};
    given.address = address;
    EXPECT_THROW(Server{given}, ConfigError) << address;
  }
  ServerOptions given{options()};
  given.address = "localhost";
  EXPECT_THAT(Server{given}.url(), HasSubstr("http://127.0.0.1:"));
  given.limits.clients = 0;
  EXPECT_THROW(Server{given}, ConfigError);
}

}  // namespace
}  // namespace stereogrid::server::testing
