// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// As the package foxglove_msgs has them for ROS 2 (github.com/foxglove/foxglove-sdk).
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::foxglove_msgs {

struct Vector2 {
  static constexpr std::string_view type_name{"foxglove_msgs/msg/Vector2"};

  double x{0};
  double y{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("x", self.x);
    visit("y", self.y);
  }
};

/// A number within the bytes of a cell.
struct PackedElementField {
  static constexpr std::string_view type_name{"foxglove_msgs/msg/PackedElementField"};
  static constexpr std::uint8_t type_uint8{1};
  static constexpr std::uint8_t type_int16{4};

  std::string name;
  std::uint32_t offset{0};  ///< bytes
  std::uint8_t type{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("name", self.name);
    visit("offset", self.offset);
    visit("type", self.type);
  }
};

struct Grid {
  static constexpr std::string_view type_name{"foxglove_msgs/msg/Grid"};

  builtin_interfaces::Time timestamp;
  std::string frame_id;
  geometry_msgs::Pose pose;  ///< pose of the corner of cell (0, 0)
  std::uint32_t column_count{0};
  Vector2 cell_size;             ///< m
  std::uint32_t row_stride{0};   ///< bytes
  std::uint32_t cell_stride{0};  ///< bytes
  std::vector<PackedElementField> fields;
  std::vector<std::uint8_t> data;  ///< x fastest, little-endian

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("timestamp", self.timestamp);
    visit("frame_id", self.frame_id);
    visit("pose", self.pose);
    visit("column_count", self.column_count);
    visit("cell_size", self.cell_size);
    visit("row_stride", self.row_stride);
    visit("cell_stride", self.cell_stride);
    visit("fields", self.fields);
    visit("data", self.data);
  }
};

}  // namespace stereogrid::messages::foxglove_msgs
