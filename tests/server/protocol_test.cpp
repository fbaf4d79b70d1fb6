// SPDX-License-Identifier: Apache-2.0
// The Foxglove protocol over a socket: handshake, each message.
#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

using ::testing::UnorderedElementsAre;

TEST(Handshake, ServerPicksASubprotocol) {
  const Server server{options()};
  for (const std::string name : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    for (const std::string& offer : {name, "other, " + name, name + ",other", "x , " + name + " ,y"}) {
      const Client client{server.port(), {.subprotocols = offer}};
      EXPECT_EQ(client.accepted().fields.at("sec-websocket-protocol"), name) << offer;
      // for the example key of RFC 6455
      EXPECT_EQ(client.accepted().fields.at("sec-websocket-accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
    }
  }
  const Client both{server.port(), {.subprotocols = "foxglove.websocket.v1, foxglove.sdk.v1"}};
  EXPECT_EQ(both.accepted().fields.at("sec-websocket-protocol"), "foxglove.websocket.v1");
  const Client two_headers{server.port(),
                           {.subprotocols = "other", .fields = "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"}};
  EXPECT_EQ(two_headers.accepted().fields.at("sec-websocket-protocol"), "foxglove.sdk.v1");
}

TEST(Handshake, WithoutASubprotocolOfOursItIsRefused) {
  const Server server{options()};
  for (const char* offer : {"", "other", "foxglove.websocket.v2", "FOXGLOVE.SDK.V1", "foxglove.sdk.v1x", ",,", " "}) {
    const HttpAnswer answer{refusal(server.port(), {.subprotocols = offer})};
    EXPECT_EQ(answer.status, 400) << offer;
    EXPECT_THAT(answer.body, HasSubstr("foxglove.websocket.v1 or foxglove.sdk.v1")) << offer;
  }
  EXPECT_EQ(server.counts().clients_ever, 0U);
}

TEST(Protocol, BeginsWithServerInfoAndChannels) {
  ServerOptions given{options()};
  given.name = "robot \"7\"";
  given.sends_time = true;
  given.parameters.values = {{"gain", 0.5}};
  Server server{given};
  const ChannelId id{server.add_channel(grid_channel("/a"))};
  Client client{server.port()};
  const Json info(Json::parse(client.receive().bytes));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "robot \"7\"");
  EXPECT_THAT(info["capabilities"].get<std::vector<std::string>>(),
              UnorderedElementsAre("connectionGraph", "parameters", "parametersSubscribe", "time"));
  EXPECT_GE(info["sessionId"].get<std::string>().size(), 16U);
  const Json advertised(Json::parse(client.receive().bytes));
  EXPECT_EQ(advertised, Json::parse(R"({"op": "advertise", "channels": [{"id": )" + std::to_string(id) +
                                    R"(, "topic": "/a", "encoding": "cdr", "schemaName": "nav_msgs/msg/OccupancyGrid",
                                    "schema": "int8[] data", "schemaEncoding": "ros2msg"}]})"));
}

TEST(Protocol, CapabilitiesAreWhatThereIs) {
  const Server server{options()};
  Client client{server.port()};
  EXPECT_THAT(client.expect("serverInfo")["capabilities"].get<std::vector<std::string>>(),
              ElementsAre("connectionGraph"));
  EXPECT_THAT(client.expect("advertise")["channels"], IsEmpty());
}

TEST(Protocol, ChannelsComeAndGo) {
  Server server{options()};
  Client client{server.port()};
  EXPECT_THAT(client.expect("advertise")["channels"], IsEmpty());
  const ChannelId id{server.add_channel(grid_channel("/later"))};
  EXPECT_EQ(client.expect("advertise")["channels"][0]["topic"], "/later");
  subscribe(server, client, id);
  server.remove_channel(id);
  EXPECT_THAT(client.expect("unadvertise")["channelIds"].get<std::vector<ChannelId>>(), ElementsAre(id));
  EXPECT_FALSE(server.wanted(id));
  send(server, id, 1, "ignored");
  EXPECT_NE(server.add_channel(grid_channel("/later")), id) << "an id of another schema must not come again";
  EXPECT_EQ(Json::parse(client.receive().bytes)["op"], "advertise") << "and nothing before it";
}

TEST(Protocol, MessagesHaveSubscriptionAndStamp) {
  Server server{options()};
  const ChannelId id{server.add_channel(grid_channel())};
  Client client{server.port()};
  EXPECT_FALSE(server.wanted(id));
  send(server, id, 1, "nobody wants it");
  client.send({{"op", "subscribe"}, {"subscriptions", {{{"id", 0xfedcba98}, {"channelId", id}}}}});
  ASSERT_TRUE(soon([&] { return server.wanted(id); }));
  const std::string payload{"\0\1\2\xff grid", 9};
  send(server, id, 0x0123456789abcdef, payload);
  const std::string bytes{client.expect_binary()};
  EXPECT_EQ(bytes.substr(0, 13), (std::string{"\x01\x98\xba\xdc\xfe\xef\xcd\xab\x89\x67\x45\x23\x01", 13}));
  EXPECT_EQ(bytes.substr(13), payload);
  EXPECT_EQ(server.counts().messages_sent, 1U);
  EXPECT_EQ(server.counts().bytes_sent, 9U);

  client.send({{"op", "unsubscribe"}, {"subscriptionIds", {0xfedcba98}}});
  EXPECT_TRUE(soon([&] { return !server.wanted(id); }));
}

TEST(Protocol, SizesOfEveryLengthOfAFrame) {
  Server server{options()};
  const ChannelId id{server.add_channel(grid_channel())};
  Client client{server.port()};
  subscribe(server, client, id);
  for (const std::size_t size : {0U, 1U, 112U, 113U, 65522U, 65523U, 3'000'000U}) {
    const std::string payload(size, 'x');
    send(server, id, size, payload);
    EXPECT_TRUE(data_of(client.expect_binary()).payload == payload) << size;
  }
}

TEST(Protocol, ALatchedChannelSendsItsLastMessageToWhoComesLater) {
  Server server{options()};
  Channel channel{grid_channel("/map")};
  channel.latched = true;
  const ChannelId latched{server.add_channel(channel)};
  const ChannelId other{server.add_channel(grid_channel("/other"))};
  EXPECT_TRUE(server.wanted(latched)) << "so that the owner makes its messages";
  send(server, latched, 1, "old");
  send(server, latched, 2, "last");
  send(server, other, 3, "gone");
  for (int i{0}; i < 2; ++i) {
    Client client{server.port()};
    subscribe(server, client, other);
    client.send({{"op", "subscribe"}, {"subscriptions", {{{"id", 9}, {"channelId", latched}}}}});
    const Data data{data_of(client.expect_binary())};
    EXPECT_EQ(data.subscription, 9U);
    EXPECT_EQ(data.stamp_ns, 2U);
    EXPECT_EQ(data.payload, "last");
  }
}

TEST(Protocol, AMessageJustBehindItsChannelIsNotLost) {
  Server server{options()};
  std::vector<ChannelId> channels;
  for (int i{0}; i < 100; ++i) {
    Channel channel{grid_channel("/map" + std::to_string(i))};
    channel.latched = true;
    channels.push_back(server.add_channel(channel));
    send(server, channels.back(), 1, std::to_string(i));
  }
  Client client{server.port()};
  for (std::size_t i{0}; i < channels.size(); ++i) {
    client.send({{"op", "subscribe"}, {"subscriptions", {{{"id", i}, {"channelId", channels[i]}}}}});
    EXPECT_EQ(data_of(client.expect_binary()).payload, std::to_string(i));
  }
}

TEST(Protocol, TimeAndStatus) {
  ServerOptions given{options()};
  given.sends_time = true;
  Server server{given};
  Client client{server.port()};
  client.expect("advertise");
  server.send_time(0x0102030405060708);
  EXPECT_EQ(client.expect_binary(), "\x02\x08\x07\x06\x05\x04\x03\x02\x01");
  server.send_status(StatusLevel::warning, "no pair for 2 s \xff");
  const Json status(client.expect("status"));
  EXPECT_EQ(status["level"], 1);
  EXPECT_EQ(status["message"], "no pair for 2 s \uFFFD");
}

TEST(Protocol, TheConnectionGraphSaysWhoSubscribes) {
  ServerOptions given{options()};
  given.name = "node";
  Server server{given};
  const ChannelId id{server.add_channel(grid_channel("/a"))};
  Client watcher{server.port()};
  watcher.send({{"op", "subscribeConnectionGraph"}});
  Json graph(watcher.expect("connectionGraphUpdate"));
  EXPECT_EQ(graph["publishedTopics"], Json::parse(R"([{"name": "/a", "publisherIds": ["node"]}])"));
  EXPECT_EQ(graph["subscribedTopics"], Json::parse(R"([{"name": "/a", "subscriberIds": []}])"));
  EXPECT_THAT(graph["advertisedServices"], IsEmpty());
  EXPECT_THAT(graph["removedTopics"], IsEmpty());
  EXPECT_THAT(graph["removedServices"], IsEmpty());
  {
    Client other{server.port()};
    other.send({{"op", "subscribe"}, {"subscriptions", {{{"id", 1}, {"channelId", id}}}}});
    graph = watcher.expect("connectionGraphUpdate");
    EXPECT_EQ(graph["subscribedTopics"], Json::parse(R"([{"name": "/a", "subscriberIds": ["client 2"]}])"));
  }
  graph = watcher.expect("connectionGraphUpdate");
  EXPECT_EQ(graph["subscribedTopics"], Json::parse(R"([{"name": "/a", "subscriberIds": []}])"));
  server.remove_channel(id);
  graph = watcher.expect("connectionGraphUpdate");
  EXPECT_THAT(graph["publishedTopics"], IsEmpty());
  EXPECT_EQ(graph["removedTopics"], Json::parse(R"(["/a"])"));
  watcher.send({{"op", "unsubscribeConnectionGraph"}});
  watcher.send({{"op", "unsubscribe"}, {"subscriptionIds", {77}}});
  EXPECT_EQ(watcher.expect("status")["level"], 1);  // and no graph before it: expect() of the op passes over it
  server.add_channel(grid_channel("/b"));
  EXPECT_EQ(Json::parse(watcher.receive().bytes)["op"], "advertise");
  EXPECT_EQ(watcher.receive(100ms).opcode, 0) << "no graph any more";
}

TEST(Protocol, SubscriptionsThatCannotBeAreWarnedOf) {
  Server server{options()};
  const ChannelId a{server.add_channel(grid_channel("/a"))};
  const ChannelId b{server.add_channel(grid_channel("/b"))};
  Client client{server.port()};
  subscribe(server, client, a);
  const auto answer{[&](std::uint32_t id, ChannelId channel) {
    client.send({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}});
    const Json status(client.expect("status"));
    EXPECT_EQ(status["level"], 1);
    return status["message"].get<std::string>();
  }};
  EXPECT_THAT(answer(50, 999), HasSubstr("there is no channel 999"));
  EXPECT_THAT(answer(a, b), HasSubstr("is in use"));
  EXPECT_THAT(answer(50, a), HasSubstr("is subscribed already"));
  client.send({{"op", "unsubscribe"}, {"subscriptionIds", {50, 51, 52}}});
  EXPECT_EQ(client.expect("status")["message"],
            "unsubscribe: there is no subscription 50. (and 2 more of the same request)");
  EXPECT_EQ(server.counts().faults, 0U) << "channels may go while a request is under way";
}

}  // namespace
}  // namespace stereogrid::server::testing
