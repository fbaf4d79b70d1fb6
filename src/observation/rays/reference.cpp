// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <cmath>
#include <numeric>

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

void count_rays(Reference&, const Matches& matches, const Rig& rig, const Ground& ground,
                const UDisparityConfig& config, RayWorkspace& space) {
  space.place(rig, ground, config);
  space.sums.fill(0);
  for (int v{0}; v < space.height; ++v) {
    for (int u{0}; u < space.width; ++u) {
      const float obstacle{matches.obstacle(u, v)};
      const float road{matches.road(u, v)};
      count_ray(obstacle, road, space.row(u, v, obstacle > 0 ? obstacle : road), space.upright, space.bins,
                [&](int bin, PackedRays rays) { space.sums(bin + 1, u + 1) += rays; });
    }
  }
  for (int u{0}; u < space.width; ++u) {
    PackedRays* const sums{space.sums.row(u + 1)};
    std::partial_sum(sums, sums + space.bins + 1, sums);
    space.stop_at_pattern(matches, u);
    for (int k{0}; k <= space.bins; ++k) sums[k] += space.sums(k, u);
  }
}

void project_rays(Reference&, const RayWorkspace& space, const BinGeometry& geometry, const GridInVehicle& grid,
                  View<float> cells) {
  const CellsInView in_view{geometry, grid, space.blur_px};
  for (int iy{0}; iy < cells.height; ++iy) {
    for (int ix{0}; ix < cells.width; ++ix) {
      cells(ix, iy) = occupancy_at(RaySums<Host>{space.sums.view()}, columns_max(space.height), in_view, ix, iy);
    }
  }
}

}  // namespace stereogrid
