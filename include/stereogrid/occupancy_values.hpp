// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Conversion of probabilities to 8-bit integers, as in ROS's nav_msgs/OccupancyGrid. Unknown: see `is_known`.
enum class OccupancyScale {
  percent,   ///< 100·P, rounded; −1: unknown
  trinary,   ///< 100 from P = 0.65 on, 0 up to P = 0.35; −1: between, or unknown
  nav2,      ///< for Nav2's static layer: as trinary, but 1 … 98 between; 99 would mean "inscribed"
  autoware,  ///< 100·P, 1 … 99; 50: unknown
};
constexpr std::array<std::string_view, 4> names_of(OccupancyScale) {
  return {"percent", "trinary", "nav2", "autoware"};
}

/// Value of one cell.
[[nodiscard]] STEREOGRID_EXPORT std::int8_t occupancy_value(float occupancy, OccupancyScale scale);

/// Values of all cells of a grid, in the order of nav_msgs/OccupancyGrid: row by row, x fastest, from the corner of the
/// smallest x and y.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::int8_t> occupancy_values(View<const float> occupancy,
                                                                          OccupancyScale scale);

}  // namespace stereogrid
