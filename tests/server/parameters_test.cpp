// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

struct ParametersTest : ::testing::Test {
  ParametersTest() {
    given.parameters.values = {{"gain", 2.0},
                               {"on", true},
                               {"count", std::int64_t{3}},
                               {"name", std::string{"x"}},
                               {"weights", std::vector<double>{1, 2.5}},
                               {"sizes", std::vector<std::int64_t>{1, 2}},
                               {"flags", std::vector<bool>{true, false}},
                               {"words", std::vector<std::string>{"a"}}};
    given.parameters.set = [this](const Parameter& parameter) -> std::optional<std::string> {
      const std::lock_guard lock{mutex};
      taken.push_back(parameter);
      if (parameter.name == "gain" && std::get<double>(parameter.value) > 10) return "gain has to be below 10.";
      if (parameter.name == "on") throw std::runtime_error{"the switch is broken."};
      return std::nullopt;
    };
  }

  std::size_t taken_count() {
    const std::lock_guard lock{mutex};
    return taken.size();
  }

  ServerOptions given{options()};
  std::mutex mutex;
  std::vector<Parameter> taken;
};

Json values_of(const Json& message) {
  Json values(Json::object());
  for (const Json& one : message["parameters"]) values[one["name"].get<std::string>()] = one["value"];
  return values;
}

Json set_request(const std::string& name, const Json& value) {
  return {{"op", "setParameters"}, {"parameters", {{{"name", name}, {"value", value}}}}, {"id", "r"}};
}

using Parameters = ParametersTest;

TEST_F(Parameters, AreRead) {
  const Server server{given};
  Client client{server.port()};
  client.send({{"op", "getParameters"}, {"parameterNames", Json::array()}, {"id", "7"}});
  const Json all(client.expect("parameterValues"));
  EXPECT_EQ(all["id"], "7");
  EXPECT_EQ(values_of(all), Json::parse(R"({"gain": 2.0, "on": true, "count": 3, "name": "x", "weights": [1.0, 2.5],
                                            "sizes": [1, 2], "flags": [true, false], "words": ["a"]})"));
  for (const Json& one : all["parameters"]) {
    const std::string name{one["name"]};
    EXPECT_EQ(one.value("type", ""), name == "gain" ? "float64" : name == "weights" ? "float64_array" : "") << name;
  }
  client.send({{"op", "getParameters"}, {"parameterNames", {"count", "none"}}});
  EXPECT_THAT(client.expect("status")["message"].get<std::string>(), HasSubstr("there is no parameter 'none'"));
  const Json some(client.expect("parameterValues"));
  EXPECT_FALSE(some.contains("id"));
  EXPECT_EQ(values_of(some), Json::parse(R"({"count": 3})"));
}

TEST_F(Parameters, AreSet) {
  const Server server{given};
  Client client{server.port()};
  const auto set{[&](const std::string& name, const Json& value) {
    client.send(set_request(name, value));
    const Json answer(client.expect("parameterValues"));
    EXPECT_EQ(answer["id"], "r");
    return values_of(answer)[name];
  }};
  EXPECT_EQ(set("gain", 3.5), 3.5);
  EXPECT_EQ(set("gain", 4), 4.0) << "JavaScript writes 4.0 so";
  EXPECT_EQ(set("count", -5), -5);
  EXPECT_EQ(set("name", "ü"), "ü");
  EXPECT_EQ(set("weights", Json::array({1, 2, 3})), Json::array({1, 2, 3}));
  EXPECT_EQ(set("weights", Json::array({1, 0.5})), Json::array({1, 0.5}));
  EXPECT_EQ(set("sizes", Json::array()), Json::array());
  EXPECT_EQ(set("weights", Json::array()), Json::array());
  EXPECT_EQ(set("words", Json::array()), Json::array());
  EXPECT_EQ(set("flags", Json::array({false})), Json::array({false}));
  EXPECT_EQ(set("words", Json::array({"b", "c"})), Json::array({"b", "c"}));
  EXPECT_EQ(taken_count(), 11U);
  EXPECT_TRUE(std::holds_alternative<double>(taken[1].value));
  EXPECT_EQ(server.counts().faults, 0U);
}

TEST_F(Parameters, ARefusalLeavesTheValue) {
  const Server server{given};
  Client client{server.port()};
  const auto refusal_of{[&](const std::string& name, const Json& value) {
    client.send(set_request(name, value));
    const Json status(client.expect("status"));
    EXPECT_EQ(status["level"], 2);
    client.expect("parameterValues");
    return status["message"].get<std::string>();
  }};
  EXPECT_EQ(refusal_of("gain", 11), "setParameters: 'gain': gain has to be below 10.");
  EXPECT_EQ(refusal_of("on", false), "setParameters: 'on': the switch is broken.");
  EXPECT_EQ(refusal_of("count", 2.5), "setParameters: 'count': it has to be a whole number.");
  EXPECT_EQ(refusal_of("count", 18446744073709551615U), "setParameters: 'count': it has to be a whole number.");
  EXPECT_EQ(refusal_of("name", 1), "setParameters: 'name': it has to be a string.");
  EXPECT_EQ(refusal_of("weights", Json::array({"a"})), "setParameters: 'weights': it has to be an array of numbers.");
  EXPECT_EQ(refusal_of("none", 1), "setParameters: 'none': there is no such parameter.");
  client.send({{"op", "getParameters"}, {"parameterNames", {"gain", "on", "count", "name"}}});
  EXPECT_EQ(values_of(client.expect("parameterValues")),
            Json::parse(R"({"gain": 2.0, "on": true, "count": 3, "name": "x"})"));
}

TEST_F(Parameters, WithoutASetterAreOnlyRead) {
  given.parameters.set = nullptr;
  const Server server{given};
  Client client{server.port()};
  client.send(set_request("count", 4));
  EXPECT_THAT(client.expect("status")["message"].get<std::string>(), HasSubstr("it can only be read"));
}

TEST_F(Parameters, ChangesAreSentToSubscribers) {
  Server server{given};
  Client all{server.port()};
  Client one{server.port()};
  Client none{server.port()};
  all.send({{"op", "subscribeParameterUpdates"}, {"parameterNames", Json::array()}});
  one.send({{"op", "subscribeParameterUpdates"}, {"parameterNames", {"count", "none"}}});
  for (Client* const client : {&all, &one}) {  // answers are in the order of requests
    client->send({{"op", "getParameters"}, {"parameterNames", {"on"}}});
    client->expect("parameterValues");
  }
  none.send(set_request("gain", 5));
  EXPECT_EQ(values_of(all.expect("parameterValues")), Json::parse(R"({"gain": 5.0})"));
  server.set_parameter({"count", std::int64_t{8}});
  EXPECT_EQ(values_of(all.expect("parameterValues")), Json::parse(R"({"count": 8})"));
  const Json changed(one.expect("parameterValues"));
  EXPECT_EQ(values_of(changed), Json::parse(R"({"count": 8})"));
  EXPECT_FALSE(changed.contains("id"));
  EXPECT_EQ(taken_count(), 1U) << "the owner's own word is not asked for again";

  one.send({{"op", "unsubscribeParameterUpdates"}, {"parameterNames", {"count"}}});
  all.send({{"op", "unsubscribeParameterUpdates"}, {"parameterNames", Json::array()}});
  for (Client* const client : {&all, &one}) {
    client->send({{"op", "getParameters"}, {"parameterNames", {"count"}}, {"id", "now"}});
    client->expect("parameterValues");
  }
  server.set_parameter({"count", std::int64_t{9}});
  EXPECT_EQ(all.receive(100ms).opcode, 0);
  EXPECT_EQ(one.receive(100ms).opcode, 0);
}

TEST_F(Parameters, MoreThanThereAreAreNotAskedFor) {
  const Server server{given};
  Client client{server.port()};
  Json many(Json::array());
  for (int i{0}; i < 9; ++i) many.push_back({{"name", "count"}, {"value", i}});
  client.send({{"op", "setParameters"}, {"parameters", many}});
  EXPECT_THAT(client.expect("status")["message"].get<std::string>(), HasSubstr("more than there are"));
  EXPECT_EQ(taken_count(), 0U);
}

TEST_F(Parameters, OfTheOwnerAreChecked) {
  Server server{given};
  EXPECT_THROW(server.set_parameter({"none", true}), ConfigError);
  EXPECT_THROW(server.set_parameter({"count", 1.0}), ConfigError);
  EXPECT_THROW(server.set_parameter({"gain", std::numeric_limits<double>::quiet_NaN()}), ConfigError);
  const auto with{[](std::vector<Parameter> values) {
    ServerOptions bad{options()};
    bad.parameters.values = std::move(values);
    return bad;
  }};
  EXPECT_THROW(Server{with({{"", true}})}, ConfigError);
  EXPECT_THROW(Server{with({{"a", true}, {"a", false}})}, ConfigError);
  EXPECT_THROW(Server{with({{"a", std::vector<double>{HUGE_VAL}}})}, ConfigError);
}

}  // namespace
}  // namespace stereogrid::server::testing
