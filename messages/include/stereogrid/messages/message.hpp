// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>
#include <type_traits>

namespace stereogrid::messages {

// A message is a plain struct that begins with STEREOGRID_MESSAGE: its type, such as "nav_msgs/msg/OccupancyGrid", and
// its fields in the order of ROS's definition. Code that writes, reads or describes messages is a visitor of these
// fields. Fields are numbers, bool, std::byte, std::string, other messages, and std::array or std::vector of those.
#define STEREOGRID_MESSAGE(TYPE, ...)                                    \
  static constexpr std::string_view field_names{#__VA_ARGS__};           \
  template <class Visitor>                                               \
  void visit_fields(Visitor&& visit) {                                   \
    ::stereogrid::messages::visit_each<field_names>(visit, __VA_ARGS__); \
  }                                                                      \
  template <class Visitor>                                               \
  void visit_fields(Visitor&& visit) const {                             \
    ::stereogrid::messages::visit_each<field_names>(visit, __VA_ARGS__); \
  }                                                                      \
  static constexpr std::string_view type_name = TYPE

/// Calls visit(name, field) for each field. `names` is separated by commas.
template <const std::string_view& names, class Visitor, class... Fields>
void visit_each(Visitor& visit, Fields&... fields) {
  static constexpr auto each{[] {
    std::array<std::string_view, sizeof...(Fields)> split;
    std::size_t begin{0};
    for (auto& name : split) {
      name = names.substr(begin, names.find(',', begin) - begin);
      begin += name.size() + 2;
    }
    return split;
  }()};
  const auto* name{each.data()};
  (visit(*name++, fields), ...);
}

template <class T>
concept Message = std::convertible_to<decltype(T::type_name), std::string_view>;

template <class T>
concept Primitive = std::is_arithmetic_v<T> || std::is_same_v<T, std::byte>;

}  // namespace stereogrid::messages
