// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "host_device.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Columns of a sector of the relief, and of the terrain's samples.
constexpr int sector_px{8};
constexpr int relief_bins_per_px{2};

/// Columns behind the last whole sector belong to it.
STEREOGRID_HD constexpr int relief_sectors(int width_px) {
  return width_px < sector_px ? 1 : width_px / sector_px;
}

/// Height of the local ground over the plane, as rows of the image: a pixel in row v is as high over the local ground
/// as one of row v + rows_at with the same disparity over the plane. Empty: the ground is the plane.
template <class Space>
struct Relief {
  View<const std::int16_t, Space> rows;  ///< (bin of half a pixel of disparity, sector)

  [[nodiscard]] STEREOGRID_HD bool is_plane() const { return rows.width == 0; }
  /// Not of a plane. `disparity` ≥ 0.
  [[nodiscard]] STEREOGRID_HD int rows_at(int u, float disparity) const {
    const int bin{static_cast<int>(disparity * relief_bins_per_px)};
    const int sector{u / sector_px};
    return rows(bin < rows.width ? bin : rows.width - 1, sector < rows.height ? sector : rows.height - 1);
  }
};

/// True: the ground under column u is the plane.
inline bool is_level(const Relief<Host>& relief, int u) {
  if (relief.is_plane()) return true;
  const int sector{u / sector_px < relief.rows.height ? u / sector_px : relief.rows.height - 1};
  const std::int16_t* const rows{relief.rows.row(sector)};
  return std::all_of(rows, rows + relief.rows.width, [](std::int16_t raised) { return raised == 0; });
}

}  // namespace stereogrid
