// SPDX-License-Identifier: Apache-2.0
#include "foxglove/protocol.hpp"

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

using Json = nlohmann::json;

constexpr int deepest{8};  // an array of values within setParameters is at 4

/// Limit to a client's own text in an error message.
std::string shortened(std::string text) {
  constexpr std::size_t longest{60};
  if (text.size() > longest) text = text.substr(0, longest) + "…";
  return text;
}

const Json& member(const Json& object, const char* key) {
  const auto found{object.find(key)};
  if (found == object.end()) throw InputError{std::string{"the field '"} + key + "' is missing."};
  return *found;
}

const Json& list(const Json& object, const char* key) {
  const Json& value{member(object, key)};
  if (!value.is_array()) throw InputError{std::string{"'"} + key + "' has to be an array."};
  return value;
}

std::string checked_text(const Json& value, const char* what) {
  if (!value.is_string()) throw InputError{std::string{"'"} + what + "' has to be a string."};
  return value.get<std::string>();
}

std::uint32_t id_of(const Json& value, const char* what) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError{std::string{"'"} + what + "' has to be a whole number from 0 to 4294967295."};
  }
  return value.get<std::uint32_t>();
}

const Json& object_of(const Json& value, const char* what) {
  if (!value.is_object()) throw InputError{std::string{"'"} + what + "' has to hold objects."};
  return value;
}

std::optional<std::string> request_id(const Json& message) {
  const auto found{message.find("id")};
  if (found == message.end() || found->is_null()) return std::nullopt;
  return checked_text(*found, "id");
}

std::vector<std::string> names_of(const Json& message) {
  std::vector<std::string> names;
  for (const Json& name : list(message, "parameterNames")) names.push_back(checked_text(name, "parameterNames"));
  return names;
}

bool is_whole(const Json& value) {
  return value.is_number_integer() &&
         (!value.is_number_unsigned() || value.get<std::uint64_t>() <= std::uint64_t{INT64_MAX});
}

bool all(const Json& array, const std::function<bool(const Json&)>& test) {
  for (const Json& value : array) {
    if (!test(value)) return false;
  }
  return true;
}

ParameterValue array_value(const Json& array, const std::string& name) {
  if (all(array, [](const Json& value) { return value.is_boolean(); })) return array.get<std::vector<bool>>();
  if (all(array, is_whole)) return array.get<std::vector<std::int64_t>>();
  if (all(array, [](const Json& value) { return value.is_number(); })) return array.get<std::vector<double>>();
  if (all(array, [](const Json& value) { return value.is_string(); })) return array.get<std::vector<std::string>>();
  throw InputError{"the array given for parameter '" + shortened(name) +
                   "' has to hold numbers only, or booleans, or strings."};
}

ParameterValue value_of(const Json& value, const std::string& name) {
  if (value.is_boolean()) return value.get<bool>();
  if (is_whole(value)) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array()) return array_value(value, name);
  throw InputError{"the value given for parameter '" + shortened(name) +
                   "' has to be a number, a boolean, a string, or an array of these."};
}

Request subscribe(const Json& message) {
  Subscribe request;
  for (const Json& one : list(message, "subscriptions")) {
    const Json& entry{object_of(one, "subscriptions")};
    request.subscriptions.push_back({id_of(member(entry, "id"), "id"), id_of(member(entry, "channelId"), "channelId")});
  }
  return request;
}

Request unsubscribe(const Json& message) {
  Unsubscribe request;
  for (const Json& id : list(message, "subscriptionIds")) request.ids.push_back(id_of(id, "subscriptionIds"));
  return request;
}

Request set_parameters(const Json& message) {
  SetParameters request{{}, request_id(message)};
  for (const Json& one : list(message, "parameters")) {
    const Json& entry{object_of(one, "parameters")};
    const std::string name{checked_text(member(entry, "name"), "name")};
    if (!entry.contains("value") || entry["value"].is_null()) {
      throw InputError{"parameter '" + shortened(name) + "' cannot be removed: give it a value."};
    }
    if (entry.contains("type") && entry["type"] == "byte_array") {
      throw InputError{"parameter '" + shortened(name) + "' cannot be a byte_array: this server has none."};
    }
    request.parameters.push_back({name, value_of(entry["value"], name)});
  }
  return request;
}

using Reader = std::function<Request(const Json&)>;

Reader refuse(const std::string& capability) {
  return [capability](const Json&) -> Request { throw InputError{"this server does not offer " + capability + "."}; };
}

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> by_op{
      {"subscribe", subscribe},
      {"unsubscribe", unsubscribe},
      {"getParameters",
       [](const Json& message) {
         return GetParameters{names_of(message), request_id(message)};
       }},
      {"setParameters", set_parameters},
      {"subscribeParameterUpdates", [](const Json& message) { return SubscribeParameters{names_of(message)}; }},
      {"unsubscribeParameterUpdates", [](const Json& message) { return UnsubscribeParameters{names_of(message)}; }},
      {"subscribeConnectionGraph", [](const Json&) { return SubscribeGraph{}; }},
      {"unsubscribeConnectionGraph", [](const Json&) { return UnsubscribeGraph{}; }},
      {"advertise", refuse("clientPublish")},
      {"unadvertise", refuse("clientPublish")},
      {"fetchAsset", refuse("assets")}};
  return by_op;
}

/// Counts open brackets outside of strings. A callback of the parser would make it quadratic in the number of members.
bool is_too_deep(std::string_view text) {
  int depth{0};
  bool in_string{false};
  for (std::size_t i{0}; i < text.size(); ++i) {
    const char c{text[i]};
    if (c == '"') in_string = !in_string;
    if (c == '\\' && in_string) ++i;
    if (in_string) continue;
    if ((c == '[' || c == '{') && ++depth > deepest + 1) return true;
    if (c == ']' || c == '}') --depth;
  }
  return false;
}

Json parsed(std::string_view text) {
  if (is_too_deep(text)) throw InputError{"the JSON is nested too deeply."};
  Json message(Json::parse(text, nullptr, false));  // no braces: they would make a list of it
  if (message.is_discarded()) throw InputError{"a text message has to be JSON in UTF-8."};
  if (!message.is_object()) throw InputError{"a text message has to be a JSON object."};
  return message;
}

}  // namespace

Request parse_request(std::string_view text) {
  const Json message(parsed(text));
  const std::string op{checked_text(member(message, "op"), "op")};
  const auto reader{readers().find(op)};
  if (reader == readers().end()) throw InputError{"unknown operation: '" + shortened(op) + "'."};
  try {
    return reader->second(message);
  } catch (const InputError& error) {
    throw InputError{op + ": " + error.what()};
  }
}

std::string error_on_binary(std::string_view bytes) {
  if (bytes.empty()) return "a binary message has to begin with an operation; this one is empty.";
  switch (bytes[0]) {
    case 1:
      return "message data: this server does not offer clientPublish.";
    case 2:
      return "service call: this server does not offer services.";
    default:
      return "unknown binary operation: " + std::to_string(static_cast<unsigned char>(bytes[0])) + ".";
  }
}

}  // namespace stereogrid::server
