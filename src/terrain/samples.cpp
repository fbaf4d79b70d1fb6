// SPDX-License-Identifier: Apache-2.0
#include "terrain/samples.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "geometry/relief.hpp"

namespace stereogrid::plain {

void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians) {
  for (int v{rows.begin}; v < rows.end; ++v) {
    std::array<float, sector_px> found{};
    std::size_t count{0};
    for (int u{column}; u < std::min(column + sector_px, obstacle.width); ++u) {
      const float disparity{std::max(obstacle(u, v), road(u, v))};
      if (!(disparity > 0)) continue;
      std::size_t place{count++};
      for (; place > 0 && found[place - 1] > disparity; --place) found[place] = found[place - 1];
      found[place] = disparity;
    }
    *medians++ = count < samples_min ? 0.0f : found[count / 2];
  }
}

}  // namespace stereogrid::plain

namespace stereogrid {
namespace {

/// Rows that are read together.
constexpr int read_rows{16};

}  // namespace

// Some rows of all sectors at a time: neighbours share cache lines.
void find_medians(View<const float> obstacle, View<const float> road, int begin, int end, int first_row,
                  View<float> medians) {
  for (int v{first_row}; v < medians.width;) {
    const int rows{medians.width - v < 2 * read_rows ? medians.width - v : read_rows};
    for (int sector{begin}; sector < end; ++sector) {
      find_medians(obstacle, road, sector * sector_px, {v, v + rows}, medians.row(sector) + v);
    }
    v += rows;
  }
}

SampledGround::SampledGround(const TerrainCamera& level_camera, const TerrainLimits& vehicle_limits, int width_px,
                             int height_px)
    : camera{level_camera}, limits{vehicle_limits} {
  const float middle{camera.tangent(static_cast<float>(terrain_sectors(width_px) * sector_px) / 2, 0)};
  const float row{(-limits.slope / 2 - middle) / camera.tangent_per_v};
  first_row = static_cast<int>(std::clamp(row, 0.0f, static_cast<float>(height_px)));
}

}  // namespace stereogrid
