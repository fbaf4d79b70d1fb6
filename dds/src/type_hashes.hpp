// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace stereogrid::dds {

/// Hash of a type by rosidl's rule (REP 2011, since Iron): "RIHS01_" and the SHA-256 of its type description.
/// `definition`: schema encoding "ros2msg" with bool, byte, numbers, string, and arrays without a bound.
/// Throws InputError: another kind of field.
[[nodiscard]] std::string type_hash(std::string_view ros_type, std::string_view definition);

/// Definition of a type that this library's users subscribe to; "": none of them.
[[nodiscard]] std::string_view definition_of_subscribed(std::string_view ros_type);

}  // namespace stereogrid::dds
