// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <string_view>
#include <type_traits>

namespace stereogrid::messages {

// A message is a plain struct with `type_name`, such as "nav_msgs/msg/OccupancyGrid", and visit_fields, which lists its
// fields once, in the order of ROS's definition. What writes, reads or describes messages is a visitor of that list.
// Fields are numbers, bool, std::byte, std::string, other messages, and std::array or std::vector of those.

template <class T>
concept Message = std::convertible_to<decltype(T::type_name), std::string_view>;

template <class T>
concept Primitive = std::is_arithmetic_v<T> || std::is_same_v<T, std::byte>;

}  // namespace stereogrid::messages
