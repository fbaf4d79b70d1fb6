// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/occupancy_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "stereogrid/grid.hpp"

namespace stereogrid {
namespace {

constexpr float occupied_from{0.65f};
constexpr float free_to{0.35f};

int percent_of(float occupancy) {
  return static_cast<int>(std::lround(100 * std::clamp(occupancy, 0.0f, 1.0f)));
}

// Between free and occupied.
int value_between(float occupancy) {
  return 1 + static_cast<int>(std::lround(97 * (occupancy - free_to) / (occupied_from - free_to)));
}

}  // namespace

std::int8_t occupancy_value(float occupancy, OccupancyScale scale) {
  const bool is_decided{occupancy >= occupied_from || occupancy <= free_to};
  const auto value = [&]() -> int {
    if (scale == OccupancyScale::autoware) return is_known(occupancy) ? std::clamp(percent_of(occupancy), 1, 99) : 50;
    if (!is_known(occupancy)) return -1;
    if (scale == OccupancyScale::percent) return percent_of(occupancy);
    if (is_decided) return occupancy >= occupied_from ? 100 : 0;
    return scale == OccupancyScale::nav2 ? value_between(occupancy) : -1;
  };
  return static_cast<std::int8_t>(value());
}

std::vector<std::int8_t> occupancy_values(View<const float> occupancy, OccupancyScale scale) {
  std::vector<std::int8_t> values;
  values.reserve(static_cast<std::size_t>(occupancy.width) * static_cast<std::size_t>(occupancy.height));
  for (int iy{0}; iy < occupancy.height; ++iy) {
    for (int ix{0}; ix < occupancy.width; ++ix) values.push_back(occupancy_value(occupancy(ix, iy), scale));
  }
  return values;
}

}  // namespace stereogrid
