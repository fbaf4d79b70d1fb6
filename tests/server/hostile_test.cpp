// SPDX-License-Identifier: Apache-2.0
// Clients that do what they should not, or nothing at all.
#include "foxglove/protocol.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

/// Text messages and the answers to them.
const std::vector<std::pair<std::string, std::string>> malformed{
    {"", "has to be JSON"},
    {"{", "has to be JSON"},
    {"nonsense", "has to be JSON"},
    {"[]", "has to be a JSON object"},
    {"3", "has to be a JSON object"},
    {"{}", "'op' is missing"},
    {R"({"op": 3})", "'op' has to be a string"},
    {R"({"op": "fly"})", "unknown operation: 'fly'"},
    {R"({"op": "subscribe"})", "'subscriptions' is missing"},
    {R"({"op": "subscribe", "subscriptions": 1})", "has to be an array"},
    {R"({"op": "subscribe", "subscriptions": [1]})", "has to hold objects"},
    {R"({"op": "subscribe", "subscriptions": [{"id": 1}]})", "'channelId' is missing"},
    {R"({"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]})", "from 0 to 4294967295"},
    {R"({"op": "subscribe", "subscriptions": [{"id": 4294967296, "channelId": 1}]})", "from 0 to 4294967295"},
    {R"({"op": "subscribe", "subscriptions": [{"id": 1.5, "channelId": 1}]})", "from 0 to 4294967295"},
    {R"({"op": "unsubscribe", "subscriptionIds": ["1"]})", "from 0 to 4294967295"},
    {R"({"op": "getParameters", "parameterNames": [1]})", "has to be a string"},
    {R"({"op": "getParameters", "parameterNames": [], "id": 1})", "'id' has to be a string"},
    {R"({"op": "setParameters", "parameters": [{"name": "a"}]})", "cannot be removed"},
    {R"({"op": "setParameters", "parameters": [{"name": "a", "value": null}]})", "cannot be removed"},
    {R"({"op": "setParameters", "parameters": [{"name": "a", "value": {}}]})", "has to be a number"},
    {R"({"op": "setParameters", "parameters": [{"name": "a", "value": [1, "x"]}]})", "numbers only"},
    {R"({"op": "setParameters", "parameters": [{"name": "a", "value": "AA==", "type": "byte_array"}]})", "byte_array"},
    {R"({"op": "setParameters", "parameters": [{"name": "a", "value": 1e999}]})", "has to be JSON"},
    {R"({"op": "advertise", "channels": []})", "does not offer clientPublish"},
    {R"({"op": "fetchAsset", "uri": "package://x", "requestId": 1})", "does not offer assets"},
    {std::string(50'000, '['), "nested too deeply"},
    {R"({"op": "fly", "x": "\"[[[[[[[[[[[[", "y": "\\"})", "unknown operation: 'fly'"},
    {R"({"op": "fly", "x": "\\", "y": [[[[[[[[[[[[]]]]]]]]]]]]})", "nested too deeply"},
    {R"({"op": "getParameters", "parameterNames": )" + std::string(20, '[') + std::string(20, ']') + "}",
     "nested too deeply"}};

TEST(Hostile, MalformedRequestsAreAnsweredInWords) {
  ServerOptions given{options({.faults = 100})};
  given.parameters.values = {{"a", true}};
  const Server server{given};
  Client client{server.port()};
  for (const auto& [text, words] : malformed) {
    client.send_frame(1, text);
    const Json status(client.expect("status"));
    EXPECT_EQ(status["level"], 2) << text.substr(0, 100);
    EXPECT_THAT(status["message"].get<std::string>(), HasSubstr(words)) << text.substr(0, 100);
  }
  for (const auto& [bytes, words] :
       std::vector<std::pair<std::string, std::string>>{{"", "this one is empty"},
                                                        {"\x01xxxx", "clientPublish"},
                                                        {"\x02", "services"},
                                                        {"\xff", "unknown binary operation: 255"}}) {
    client.send_frame(2, bytes);
    EXPECT_THAT(client.expect("status")["message"].get<std::string>(), HasSubstr(words));
  }
  EXPECT_EQ(server.counts().faults, malformed.size() + 4);
}

TEST(Hostile, WhoGoesOnWithThatIsClosed) {
  const Server server{options({.faults = 5})};
  Client client{server.port()};
  for (int i{0}; i < 5; ++i) client.send_frame(1, "nonsense");
  EXPECT_EQ(client.expect_close(), 1008);
  EXPECT_TRUE(soon([&] { return server.counts().clients == 0; }));
}

TEST(Hostile, TooManyRequestsClose) {
  const Server server{options({.requests_per_second = 10})};
  Client client{server.port()};
  for (int i{0}; i < 200; ++i) client.send({{"op", "unsubscribeConnectionGraph"}});
  EXPECT_EQ(client.expect_close(), 1008);
}

TEST(Hostile, TooManyBytesClose) {
  const Server server{options({.request_bytes_per_second = 10'000})};
  Client client{server.port()};
  const std::string request{R"({"op": "subscribeConnectionGraph", "x": ")" + std::string(9'000, 'x') + "\"}"};
  client.send_frame(1, request);
  client.send_frame(1, request);
  client.expect("connectionGraphUpdate");
  client.send_frame(1, request);
  EXPECT_EQ(client.expect_close(), 1008);
}

TEST(Hostile, ParsingTimeGrowsWithTheBytesOnly) {
  std::string objects{"{}"};
  for (int i{1}; i < 340'000; ++i) objects += ",{}";
  const auto start{std::chrono::steady_clock::now()};
  EXPECT_THROW(static_cast<void>(parse_request(R"({"op":"subscribe","subscriptions":[)" + objects + "]}")), InputError);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 8s) << "once 42 s";
}

TEST(Hostile, TooLongAMessageCloses) {
  const Server server{options({.request_bytes = 1000})};
  Client fits{server.port()};
  fits.send_frame(1, R"({"op": "subscribeConnectionGraph", "x": ")" + std::string(900, 'x') + "\"}");
  fits.expect("connectionGraphUpdate");
  fits.send_frame(1, std::string(1001, 'x'));
  EXPECT_EQ(fits.expect_close(), 1009);
  Client parts{server.port()};
  parts.send_frame(1, std::string(600, 'x'), false);
  parts.send_frame(0, std::string(600, 'x'));
  EXPECT_EQ(parts.expect_close(), 1009);
}

TEST(Hostile, FramesThatAreNoneClose) {
  const Server server{options()};
  for (const std::string& bytes : {std::string{"\x81\x05hello", 7},              // not masked
                                   std::string{"\x8b\x80\1\2\3\4", 6},           // unknown opcode
                                   std::string{"\xf1\x80\1\2\3\4", 6},           // reserved bits
                                   std::string{"\x80\x80\1\2\3\4", 6},           // continuation without a beginning
                                   std::string{"\x89\xfe\x01\x00\1\2\3\4", 8}})  // a long ping
  {
    Client client{server.port()};
    client.wire().send(bytes);
    EXPECT_EQ(client.expect_close(), 1002);
  }
  Client text{server.port()};
  text.send_frame(1, "{\"op\": \"\xff\xfe\"}");
  EXPECT_EQ(text.expect_close(), 1007);
}

TEST(Hostile, GarbageDoesNoHarm) {
  Server server{options({.http_timeout = 300ms})};
  const ChannelId id{server.add_channel(grid_channel())};
  std::mt19937 random{7};
  const auto noise{[&](std::size_t size) {
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    return bytes;
  }};
  for (int i{0}; i < 40; ++i) {
    Wire{server.port()}.send(noise(random() % 3000));
    const Client client{server.port()};
    client.wire().send(noise(random() % 3000));
    client.send_frame(static_cast<int>(random() % 16), noise(random() % 300));
  }
  Client client{server.port()};
  subscribe(server, client, id);
  send(server, id, 1, "still there");
  EXPECT_EQ(data_of(client.expect_binary()).payload, "still there");
  EXPECT_TRUE(soon([&] { return server.counts().clients == 1; }));
}

TEST(Hostile, SlowRequestsEnd) {
  const Server server{options({.http_timeout = 200ms})};
  const Wire silent{server.port()};
  const Wire slow{server.port()};
  slow.send("GET / HTTP/1.1\r\nHost: localhost\r\n");
  EXPECT_EQ(silent.receive_all(), "");
  const auto start{std::chrono::steady_clock::now()};
  while (std::chrono::steady_clock::now() < start + 500ms && slow.receive(20ms).empty()) slow.send("X: y\r\n");
  EXPECT_EQ(slow.receive_all(), "") << "a byte now and then is not a request";
}

TEST(Hostile, AReaderThatTakesNothingEnds) {
  ServerOptions given{options({.http_timeout = 200ms})};
  given.http.assets = {{"/large", "application/octet-stream", std::string(60'000'000, 'x')}};
  const Server server{given};
  const Wire wire{server.port(), 65'536};
  wire.send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  std::this_thread::sleep_for(1s);
  EXPECT_LT(wire.receive_all().size(), 60'000'000U);
}

TEST(Hostile, DeadClientsAreNoticed) {
  const Server server{options({.idle_timeout = 1000ms})};
  Client alive{server.port()};
  const Client half_open{server.port()};  // answers no ping
  Client crashed{server.port()};
  crashed.wire().reset();
  EXPECT_TRUE(soon([&] { return server.counts().clients == 2; }));
  const auto start{std::chrono::steady_clock::now()};
  while (std::chrono::steady_clock::now() < start + 3000ms) alive.receive(50ms);  // answers pings
  EXPECT_EQ(server.counts().clients, 1U);
}

TEST(Hostile, RepliesThatNobodyReadsClose) {
  ServerOptions given{options({.control_bytes = 100'000, .requests_per_second = 100'000})};
  given.parameters.values = {{"long", std::string(20'000, 'x')}};
  const Server server{given};
  Client client{server.port(), {}, 4096};
  client.expect("advertise");
  const std::string request{R"({"op": "getParameters", "parameterNames": []})"};
  EXPECT_TRUE(soon([&] {
    for (int i{0}; i < 20; ++i) client.send_frame(1, request);
    return server.counts().clients == 0;
  }));
  EXPECT_EQ(server.counts().clients_ever, 1U);
}

TEST(Hostile, UnfinishedRequestsLeaveRoomForOthers) {
  ServerOptions given{options({.connections = 12, .connections_per_address = 8})};
  given.http.assets = {{"/", "text/html", "front"}, {"/large", "text/plain", std::string(60'000'000, 'x')}};
  const Server server{given};
  std::vector<Wire> held;
  for (int i{0}; i < 40; ++i) {
    held.emplace_back(server.port(), 4096);
    held.back().send(i % 2 == 0 ? "GET / HTTP/1.1\r\n" : "GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  EXPECT_EQ(get(server.port(), "/").status, 200);
  EXPECT_TRUE(soon([&] { return server.counts().refused >= 32; }));
  const std::string other_request{"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"};
  const Wire other{server.port(), 0, "127.0.0.1", "127.0.0.2"};
  EXPECT_EQ(ask(other, other_request).status, 200);
  for (int i{0}; i < 40; ++i) held.emplace_back(server.port(), 4096);
  EXPECT_EQ(get(server.port(), "/").status, 200);
  EXPECT_EQ(ask(other, other_request).status, 200) << "ended for connections of another address";
}

TEST(Hostile, NumbersOfClientsAreLimited) {
  ServerOptions given{options({.clients = 2, .connections = 4})};
  given.http.assets = {{"/", "text/html", "front"}};
  const Server server{given};
  std::optional<Client> first{std::in_place, server.port()};
  first->expect("advertise");
  Client second{server.port()};
  second.expect("advertise");
  const HttpAnswer answer{refusal(server.port(), {})};
  EXPECT_EQ(answer.status, 503);
  EXPECT_THAT(answer.body, StartsWith("There are as many clients"));
  ASSERT_TRUE(soon([&] { return get(server.port(), "/").status == 200; }));
  first.reset();
  EXPECT_TRUE(soon([&] { return server.counts().clients == 1; }));
  EXPECT_TRUE(soon([&] { return refusal(server.port(), {}).status == 101; })) << "there is room again";
}

TEST(Hostile, WebSocketsAreNotReplaced) {
  const Server server{options({.connections = 3})};
  Client first{server.port()};
  first.expect("advertise");
  Client second{server.port()};
  second.expect("advertise");
  Client third{server.port()};
  third.expect("advertise");
  EXPECT_TRUE(soon([&] { return get(server.port(), "/").status == 503; }, 2s));
  EXPECT_EQ(server.counts().clients, 3U);
}

}  // namespace
}  // namespace stereogrid::server::testing
