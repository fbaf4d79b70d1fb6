// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <map>
#include <new>

#include "stereogrid/error.hpp"
#include "stereogrid/messages/definition.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::dds {
namespace {

// Numbers of type_description_interfaces/msg/FieldType.
constexpr int nested_type{1};
constexpr int array_offset{48};
constexpr int unbounded_sequence_offset{144};
constexpr std::array<std::pair<std::string_view, int>, 13> primitives{{{"int8", 2},
                                                                       {"uint8", 3},
                                                                       {"int16", 4},
                                                                       {"uint16", 5},
                                                                       {"int32", 6},
                                                                       {"uint32", 7},
                                                                       {"int64", 8},
                                                                       {"uint64", 9},
                                                                       {"float32", 10},
                                                                       {"float64", 11},
                                                                       {"bool", 15},
                                                                       {"byte", 16},
                                                                       {"string", 17}}};

/// The text up to `end`, which is removed with it.
std::string_view take_until(std::string_view& text, std::string_view end) {
  const std::size_t at{text.find(end)};
  const std::string_view taken{text.substr(0, at)};
  text.remove_prefix(at == std::string_view::npos ? text.size() : at + end.size());
  return taken;
}

/// "nav_msgs/MapMetaData" is "nav_msgs/msg/MapMetaData".
std::string full_name(std::string_view name) {
  const std::size_t slash{name.find('/')};
  if (slash == std::string_view::npos) {
    throw InputError{"definition of a message", "unknown field type: " + std::string{name} + ".",
                     "Extend type_hashes.cpp."};
  }
  return std::string{name.substr(0, slash)} + "/msg" + std::string{name.substr(slash)};
}

/// JSON of a field's type, with the separators of Python's json.dumps.
std::string type_json(std::string_view type) {
  const std::string_view base{take_until(type, "[")};
  const bool is_array{type.size() > 1};  // "9]"; "]": a sequence
  const int offset{type.empty() ? 0 : is_array ? array_offset : unbounded_sequence_offset};
  const std::string capacity{is_array ? type.substr(0, type.size() - 1) : "0"};
  const auto* const found{std::ranges::find(primitives, base, &std::pair<std::string_view, int>::first)};
  const bool is_nested{found == primitives.end()};
  return "{\"type_id\": " + std::to_string(offset + (is_nested ? nested_type : found->second)) +
         ", \"capacity\": " + capacity + ", \"string_capacity\": 0, \"nested_type_name\": \"" +
         (is_nested ? full_name(base) : "") + "\"}";
}

std::string description_json(std::string_view type, std::string_view fields) {
  std::string json{"{\"type_name\": \"" + std::string{type} + "\", \"fields\": ["};
  for (const char* between{""}; !fields.empty(); between = ", ") {
    std::string_view name{take_until(fields, "\n")};
    const std::string_view field_type{take_until(name, " ")};
    json += between + std::string{"{\"name\": \""} + std::string{name} + "\", \"type\": " + type_json(field_type) + "}";
  }
  return json + "]}";
}

std::string sha256_hex(std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size{0};
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) throw std::bad_alloc{};
  constexpr std::string_view digits{"0123456789abcdef"};
  std::string hex;
  for (unsigned int i{0}; i < size; ++i) (hex += digits[digest.at(i) >> 4U]) += digits[digest.at(i) & 15U];
  return hex;
}

template <class... Messages>
std::string_view definition_among(std::string_view ros_type) {
  std::string_view found;
  static_cast<void>(
      ((ros_type == Messages::type_name && !(found = messages::definition_of<Messages>()).empty()) || ...));
  return found;
}

}  // namespace

std::string type_hash(std::string_view ros_type, std::string_view definition) {
  static const std::string divider{std::string(80, '=') + "\nMSG: "};
  const std::string_view own{take_until(definition, divider)};
  std::map<std::string, std::string> referenced;  // in the order of their names
  while (!definition.empty()) {
    std::string_view section{take_until(definition, divider)};
    const std::string name{full_name(take_until(section, "\n"))};
    referenced[name] = description_json(name, section);
  }
  std::string json{"{\"type_description\": " + description_json(ros_type, own) +
                   ", \"referenced_type_descriptions\": ["};
  const char* between{""};
  for (const auto& [name, description] : referenced) json += std::exchange(between, ", ") + description;
  return "RIHS01_" + sha256_hex(json + "]}");
}

std::string_view definition_of_subscribed(std::string_view ros_type) {
  using namespace messages;
  return definition_among<sensor_msgs::Image, sensor_msgs::CompressedImage, sensor_msgs::CameraInfo,
                          stereo_msgs::DisparityImage, nav_msgs::Odometry, tf2_msgs::TFMessage>(ros_type);
}

}  // namespace stereogrid::dds
