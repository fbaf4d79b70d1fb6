// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Types of the packages builtin_interfaces, std_msgs, unique_identifier_msgs and diagnostic_msgs.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/messages/message.hpp"

namespace stereogrid::messages::builtin_interfaces {

/// Time since a fixed moment; ROS: since 1970.
struct Time {
  STEREOGRID_MESSAGE("builtin_interfaces/msg/Time", sec, nanosec);

  std::int32_t sec{0};       ///< s
  std::uint32_t nanosec{0};  ///< nanoseconds of that second, below 1e9
};

struct Duration {
  STEREOGRID_MESSAGE("builtin_interfaces/msg/Duration", sec, nanosec);

  std::int32_t sec{0};  ///< s
  std::uint32_t nanosec{0};
};

}  // namespace stereogrid::messages::builtin_interfaces

namespace stereogrid::messages::std_msgs {

struct Header {
  STEREOGRID_MESSAGE("std_msgs/msg/Header", stamp, frame_id);

  builtin_interfaces::Time stamp;
  std::string frame_id;  ///< in which everything is given that has no frame of its own
};

/// Each 0 … 1.
struct ColorRGBA {
  STEREOGRID_MESSAGE("std_msgs/msg/ColorRGBA", r, g, b, a);

  float r{0};
  float g{0};
  float b{0};
  float a{0};
};

struct MultiArrayDimension {
  STEREOGRID_MESSAGE("std_msgs/msg/MultiArrayDimension", label, size, stride);

  std::string label;
  std::uint32_t size{0};
  std::uint32_t stride{0};  ///< elements
};

struct MultiArrayLayout {
  STEREOGRID_MESSAGE("std_msgs/msg/MultiArrayLayout", dim, data_offset);

  std::vector<MultiArrayDimension> dim;  ///< outermost first
  std::uint32_t data_offset{0};
};

struct Float32MultiArray {
  STEREOGRID_MESSAGE("std_msgs/msg/Float32MultiArray", layout, data);

  MultiArrayLayout layout;
  std::vector<float> data;
};

}  // namespace stereogrid::messages::std_msgs

namespace stereogrid::messages::unique_identifier_msgs {

struct UUID {
  STEREOGRID_MESSAGE("unique_identifier_msgs/msg/UUID", uuid);

  std::array<std::uint8_t, 16> uuid{};
};

}  // namespace stereogrid::messages::unique_identifier_msgs

namespace stereogrid::messages::diagnostic_msgs {

struct KeyValue {
  STEREOGRID_MESSAGE("diagnostic_msgs/msg/KeyValue", key, value);

  std::string key;
  std::string value;
};

struct DiagnosticStatus {
  STEREOGRID_MESSAGE("diagnostic_msgs/msg/DiagnosticStatus", level, name, message, hardware_id, values);

  std::byte level{0};  ///< 0: fine, 1: warning, 2: error, 3: stale
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;
};

struct DiagnosticArray {
  STEREOGRID_MESSAGE("diagnostic_msgs/msg/DiagnosticArray", header, status);

  std_msgs::Header header;
  std::vector<DiagnosticStatus> status;
};

}  // namespace stereogrid::messages::diagnostic_msgs
