// SPDX-License-Identifier: Apache-2.0
#include "foxglove/protocol.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace stereogrid::server {
namespace {

using Json = nlohmann::json;

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void append_little_endian(std::string& bytes, std::uint64_t value, int count) {
  for (int i{0}; i < count; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}

/// Without it a viewer takes 3.0 for a whole number.
const char* type_hint(const ParameterValue& value) {
  if (std::holds_alternative<double>(value)) return "float64";
  return std::holds_alternative<std::vector<double>>(value) ? "float64_array" : nullptr;
}

}  // namespace

std::string server_info(const std::string& name, const std::string& session, Features features) {
  Json capabilities(Json::array({"connectionGraph"}));
  if (features.parameters) capabilities.insert(capabilities.end(), {"parameters", "parametersSubscribe"});
  if (features.time) capabilities.push_back("time");
  return dumped({{"op", "serverInfo"},
                 {"name", name},
                 {"capabilities", capabilities},
                 {"metadata", Json::object()},
                 {"sessionId", session}});
}

std::string status(StatusLevel level, std::string_view text) {
  return dumped({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}});
}

std::string advertise(const std::map<ChannelId, const Channel*>& channels) {
  Json list(Json::array());
  for (const auto& [id, channel] : channels) {
    list.push_back({{"id", id},
                    {"topic", channel->topic},
                    {"encoding", channel->encoding},
                    {"schemaName", channel->schema_name},
                    {"schema", channel->schema},
                    {"schemaEncoding", channel->schema_encoding}});
  }
  return dumped({{"op", "advertise"}, {"channels", list}});
}

std::string unadvertise(ChannelId id) {
  return dumped({{"op", "unadvertise"}, {"channelIds", Json::array({id})}});
}

std::string parameter_values(std::span<const Parameter* const> parameters, const std::optional<std::string>& request) {
  Json list(Json::array());
  for (const Parameter* const parameter : parameters) {
    Json entry{{"name", parameter->name}};
    std::visit([&](const auto& value) { entry["value"] = value; }, parameter->value);
    if (const char* const type{type_hint(parameter->value)}) entry["type"] = type;
    list.push_back(entry);
  }
  Json message{{"op", "parameterValues"}, {"parameters", list}};
  if (request) message["id"] = *request;
  return dumped(message);
}

std::string connection_graph(const std::string& publisher, const Graph& graph,
                             const std::set<std::string>& removed_topics) {
  Json published(Json::array());
  Json subscribed(Json::array());
  for (const auto& [topic, subscribers] : graph) {
    published.push_back({{"name", topic}, {"publisherIds", Json::array({publisher})}});
    subscribed.push_back({{"name", topic}, {"subscriberIds", subscribers}});
  }
  return dumped({{"op", "connectionGraphUpdate"},
                 {"publishedTopics", published},
                 {"subscribedTopics", subscribed},
                 {"advertisedServices", Json::array()},
                 {"removedTopics", removed_topics},
                 {"removedServices", Json::array()}});
}

std::string message_head(SubscriptionId subscription, std::uint64_t stamp_ns) {
  std::string bytes{'\x01'};
  append_little_endian(bytes, subscription, 4);
  append_little_endian(bytes, stamp_ns, 8);
  return bytes;
}

std::string time_message(std::uint64_t stamp_ns) {
  std::string bytes{'\x02'};
  append_little_endian(bytes, stamp_ns, 8);
  return bytes;
}

namespace {

std::string_view trimmed(std::string_view text) {
  const auto first{text.find_first_not_of(" \t")};
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::optional<std::string> chosen_subprotocol(std::string_view header) {
  for (std::size_t start{0}; start <= header.size();) {
    const std::size_t end{std::min(header.find(',', start), header.size())};
    const std::string_view name{trimmed(header.substr(start, end - start))};
    if (name == "foxglove.websocket.v1" || name == "foxglove.sdk.v1") return std::string{name};
    start = end + 1;
  }
  return std::nullopt;
}

}  // namespace stereogrid::server
