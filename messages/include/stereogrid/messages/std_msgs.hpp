// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Types of the packages builtin_interfaces, std_msgs and unique_identifier_msgs.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace stereogrid::messages::builtin_interfaces {

/// Time since a fixed moment; ROS: since 1970.
struct Time {
  static constexpr std::string_view type_name{"builtin_interfaces/msg/Time"};

  std::int32_t sec{0};       ///< s
  std::uint32_t nanosec{0};  ///< nanoseconds of that second, below 1e9

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("sec", self.sec);
    visit("nanosec", self.nanosec);
  }
};

struct Duration {
  static constexpr std::string_view type_name{"builtin_interfaces/msg/Duration"};

  std::int32_t sec{0};  ///< s
  std::uint32_t nanosec{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("sec", self.sec);
    visit("nanosec", self.nanosec);
  }
};

}  // namespace stereogrid::messages::builtin_interfaces

namespace stereogrid::messages::std_msgs {

struct Header {
  static constexpr std::string_view type_name{"std_msgs/msg/Header"};

  builtin_interfaces::Time stamp;
  std::string frame_id;  ///< in which everything is given that has no frame of its own

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("stamp", self.stamp);
    visit("frame_id", self.frame_id);
  }
};

/// Each 0 … 1.
struct ColorRGBA {
  static constexpr std::string_view type_name{"std_msgs/msg/ColorRGBA"};

  float r{0};
  float g{0};
  float b{0};
  float a{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("r", self.r);
    visit("g", self.g);
    visit("b", self.b);
    visit("a", self.a);
  }
};

struct MultiArrayDimension {
  static constexpr std::string_view type_name{"std_msgs/msg/MultiArrayDimension"};

  std::string label;
  std::uint32_t size{0};
  std::uint32_t stride{0};  ///< elements

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("label", self.label);
    visit("size", self.size);
    visit("stride", self.stride);
  }
};

struct MultiArrayLayout {
  static constexpr std::string_view type_name{"std_msgs/msg/MultiArrayLayout"};

  std::vector<MultiArrayDimension> dim;  ///< outermost first
  std::uint32_t data_offset{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("dim", self.dim);
    visit("data_offset", self.data_offset);
  }
};

struct Float32MultiArray {
  static constexpr std::string_view type_name{"std_msgs/msg/Float32MultiArray"};

  MultiArrayLayout layout;
  std::vector<float> data;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("layout", self.layout);
    visit("data", self.data);
  }
};

}  // namespace stereogrid::messages::std_msgs

namespace stereogrid::messages::unique_identifier_msgs {

struct UUID {
  static constexpr std::string_view type_name{"unique_identifier_msgs/msg/UUID"};

  std::array<std::uint8_t, 16> uuid{};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("uuid", self.uuid);
  }
};

}  // namespace stereogrid::messages::unique_identifier_msgs
