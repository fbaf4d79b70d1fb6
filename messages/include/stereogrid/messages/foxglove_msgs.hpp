// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// As the package foxglove_msgs has them for ROS 2 (github.com/foxglove/foxglove-sdk).
#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::foxglove_msgs {

struct Vector2 {
  STEREOGRID_MESSAGE("foxglove_msgs/msg/Vector2", x, y);

  double x{0};
  double y{0};
};

/// A number within the bytes of a cell.
struct PackedElementField {
  STEREOGRID_MESSAGE("foxglove_msgs/msg/PackedElementField", name, offset, type);
  static constexpr std::uint8_t type_uint8{1};
  static constexpr std::uint8_t type_int16{4};

  std::string name;
  std::uint32_t offset{0};  ///< bytes
  std::uint8_t type{0};
};

struct Grid {
  STEREOGRID_MESSAGE("foxglove_msgs/msg/Grid", timestamp, frame_id, pose, column_count, cell_size, row_stride,
                     cell_stride, fields, data);

  builtin_interfaces::Time timestamp;
  std::string frame_id;
  geometry_msgs::Pose pose;  ///< pose of the corner of cell (0, 0)
  std::uint32_t column_count{0};
  Vector2 cell_size;             ///< m
  std::uint32_t row_stride{0};   ///< bytes
  std::uint32_t cell_stride{0};  ///< bytes
  std::vector<PackedElementField> fields;
  std::vector<std::uint8_t> data;  ///< x fastest, little-endian
};

}  // namespace stereogrid::messages::foxglove_msgs
