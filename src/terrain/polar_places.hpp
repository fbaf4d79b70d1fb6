// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "geometry/grid_in_vehicle.hpp"
#include "geometry/relief.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "terrain/model.hpp"
#include "terrain/rings.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Cells of a grid's row in the terrain's polar grid.
struct PolarPlaces {
  static constexpr int size{32};

  std::array<float, size> x;    ///< distance ahead, m
  std::array<int, size> ring;   ///< for Rings::at_place
  std::array<int, size> first;  ///< sectors first … last; none, or not ahead: first > last
  std::array<int, size> last;
};

/// Geometry that all cells of a grid have in common.
struct PolarGeometry {
  float focal_px;
  float focal_baseline_pxm;
  float cx_px;     ///< counted from the first pixel's left border
  float width_px;  ///< width of the image
  int last_sector;
  float half_m;       ///< half a cell
  float ring_places;  ///< Rings::places
  float ring_places_per_px;
};

/// Place of a cell in the terrain's polar grid: see PolarPlaces.
struct PolarPlace {
  int ring;
  int first;
  int last;
};

/// Sector of a point; outside the image one before the first, or behind the last one.
STEREOGRID_HD inline int polar_sector(const PolarGeometry& geometry, float ahead_m, float left_m) {
  constexpr float width_px{sector_px};
  const float u{geometry.cx_px - geometry.focal_px * left_m / ahead_m};
  return whole(Min(Max(u, -width_px), geometry.width_px) * (1 / width_px) + 1) - 1;
}

/// Place of the cell with the centre (x, y). A cell at the image's border has its sector.
STEREOGRID_HD inline PolarPlace polar_place(const PolarGeometry& geometry, float x, float y) {
  const float ahead_m{Max(x, geometry.half_m)};
  const float place{geometry.focal_baseline_pxm / ahead_m * geometry.ring_places_per_px};
  const int first{Max(polar_sector(geometry, ahead_m, y + geometry.half_m), 0)};
  const int right{polar_sector(geometry, ahead_m, y - geometry.half_m)};
  const int last{Max(Max(right - 1, polar_sector(geometry, ahead_m, y)), right < first ? -1 : first)};
  return {whole(Min(place, geometry.ring_places)), first, x > geometry.half_m ? Min(last, geometry.last_sector) : -1};
}

/// The same of cells ix, ix + step … of row iy, in vectors.
void find_places(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy, PolarPlaces& places);

/// Ground of a grid's cell.
struct CellGround {
  float elevation_m{std::numeric_limits<float>::quiet_NaN()};
  float sigma_m{std::numeric_limits<float>::quiet_NaN()};
  TerrainClass kind{TerrainClass::unknown};
};

/// Sectors of a cell, by class.
struct CellSectors {
  std::array<int, 5> count{};
  int sectors{0};
  float elevation_m{0};  ///< sum
  float slope{0};        ///< sum
  int seen{0};

  STEREOGRID_HD void add(const PolarCell& cell) {
    ++count[static_cast<std::size_t>(cell.kind)];
    ++sectors;
    if (std::isnan(cell.elevation_m)) return;
    elevation_m += cell.elevation_m;
    slope += cell.slope;
    ++seen;
  }
  /// At least one in `share` sectors is of that class.
  [[nodiscard]] STEREOGRID_HD bool has(TerrainClass one, int share) const {
    const int of_kind{count[static_cast<std::size_t>(one)]};
    return of_kind > 0 && share * of_kind >= sectors;
  }
  // A third of the sectors decides for edges and obstacles, half of them for ground.
  [[nodiscard]] STEREOGRID_HD TerrainClass kind() const {
    if (has(TerrainClass::drop, 3)) return TerrainClass::drop;
    if (has(TerrainClass::obstacle, 3)) return TerrainClass::obstacle;
    if (has(TerrainClass::hidden, 3)) return TerrainClass::hidden;
    return has(TerrainClass::drivable, 2) ? TerrainClass::drivable : TerrainClass::unknown;
  }
};

/// Mean of neighbouring sectors of a ring.
struct RingPart {
  int ring{no_ring};
  int first{0};
  int last{0};
  TerrainClass kind{TerrainClass::unknown};
  bool is_seen{false};
  float elevation_m{0};
  float slope{0};

  [[nodiscard]] STEREOGRID_HD bool has_ground() const { return is_seen || kind != TerrainClass::unknown; }
};

/// A frame's ground in the polar grid, read by the cells of other grids, for CPU and GPU.
template <class Space>
struct PolarGround {
  TerrainCamera camera;
  RingTable rings;
  const float* sigma_px;               ///< noise of disparities, by ring
  const float* plane_sigma_m;          ///< noise of the plane's height, by ring
  View<const PolarCell, Space> cells;  ///< (ring, sector)

  /// Ring at a place; no_ring: not ahead, or outside the rings.
  [[nodiscard]] STEREOGRID_HD int ring_of(const PolarPlace& at) const {
    return at.first > at.last ? no_ring : rings.at_place(at.ring);
  }
  [[nodiscard]] STEREOGRID_HD RingPart part_of(int ring, int first, int last) const {
    CellSectors found;
    for (int sector{first}; sector <= last; ++sector) found.add(cells(ring, sector));
    const auto seen = static_cast<float>(found.seen);
    return {ring, first, last, found.kind(), found.seen > 0, found.elevation_m / seen, found.slope / seen};
  }
  /// Ground `x_m` ahead.
  [[nodiscard]] STEREOGRID_HD CellGround ground_at(float x_m, const RingPart& part) const {
    CellGround ground;
    ground.kind = part.kind;
    if (!part.is_seen) return ground;
    ground.elevation_m = part.elevation_m + part.slope * (x_m - rings.middle_m(part.ring));
    const float noise{camera.height_sigma(camera.height_m - ground.elevation_m, part.slope, x_m, sigma_px[part.ring])};
    ground.sigma_m = std::sqrt(noise * noise + plane_sigma_m[part.ring] * plane_sigma_m[part.ring]);
    return ground;
  }
};

/// A grid whose cells read the ground.
struct GroundGrid {
  CellPlaces places;
  int width;
  int height;
};

/// A cell with ground, of one of several grids.
struct GroundCell {
  int grid;
  int cell;  ///< counted row by row
  CellGround ground;
};

}  // namespace stereogrid
