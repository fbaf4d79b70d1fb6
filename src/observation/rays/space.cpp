// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "observation/rays/rays.hpp"
#include "observation/u_disparity/model.hpp"

namespace stereogrid {

RayWorkspace::RayWorkspace(int image_width, int image_height, int disparities, bool has_relief)
    : width{image_width},
      height{image_height},
      bins{disparities * ray_bins_per_px},
      margin{largest_shift(image_width) + (has_relief ? image_height : 0)},
      shift(static_cast<std::size_t>(bins > 0 ? image_width : 0)),
      rows(static_cast<std::size_t>(bins > 0 ? image_height + 2 * margin : 0)),
      sums{bins > 0 ? bins + 1 : 0, bins > 0 ? image_width + 1 : 0} {}

void RayWorkspace::place(const Rig& rig, const Ground& ground, const UDisparityConfig& config) {
  const double slope{config.follow_roll ? -std::tan(ground.roll_rad) : 0.0};
  const int most{largest_shift(width)};
  for (int u{0}; u < width; ++u) shift[static_cast<std::size_t>(u)] = row_shift(slope, u - rig.cx_px, most);
  const RowsByHeight by_height{rig, ground};
  int row{-margin};
  for (RayRow& entry : rows) entry = ray_row(by_height, config.obstacle_height_m, row++, bins);
  upright = upright_range(ground.height_m, config.obstacle_min_height_m, config.obstacle_height_m);
}

}  // namespace stereogrid
