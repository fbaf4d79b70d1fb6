// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "terrain/terrain.hpp"
#include "terrain_scene.hpp"

namespace stereogrid::test {

inline float tangent_of(float degrees) {
  return std::tan(degrees * 3.14159265f / 180);
}

struct Vehicle {
  Rig rig;
  TerrainLimits limits;
  GridGeometry grid;
  double near_m;    ///< first range that is scored
  double far_m;     ///< last one
  double margin_m;  ///< around an edge
};

inline Vehicle car() {
  return {{640, 360, 425, 320, 180, 0.2, 1.0, 0, 0},
          {0.15f, tangent_of(20), 1.8f, 0.25f, tangent_of(6)},
          {0, -10, 0.2, 100, 100},
          2.8,
          8,
          0.4};
}

inline Vehicle robot() {
  return {{640, 400, 411, 320, 142, 0.09, 0.35, 0, 0},
          {0.03f, tangent_of(20), 0.5f, 0.1f, tangent_of(6)},
          {0, -3, 0.05, 120, 120},
          0.6,
          2,
          0.1};
}

struct Seen {
  Image<float> elevation_m;
  Image<float> sigma_m;
  Image<TerrainClass> kind;
  Image<std::int16_t> relief;
};

/// `slope`: surface that fills the view; nullptr: none.
inline Seen walked(const Vehicle& vehicle, const Image<float>& disparity, const Ground* slope = nullptr) {
  const GridGeometry& grid{vehicle.grid};
  constexpr float none_m{std::numeric_limits<float>::quiet_NaN()};
  Seen seen{{grid.nx, grid.ny, none_m}, {grid.nx, grid.ny, none_m}, {grid.nx, grid.ny}, {}};
  Rings rings{static_cast<float>(grid.cell_size_m), static_cast<float>(grid.nx * grid.cell_size_m), 64};
  SectorWalks walks{vehicle.rig, rings.capacity(), 9};
  Terrain terrain{vehicle.rig, vehicle.limits, std::move(rings), 64};
  const auto in_order = [](int count, const auto& work) { work(0, count); };
  Ground ground;
  ground.height_m = vehicle.rig.camera_height_m;
  terrain.begin(ground, slope != nullptr ? *slope : ground);
  const Image<float> none{disparity.width(), disparity.height()};
  terrain.set_noise(walks.begin(terrain.walk_frame(), disparity.view(), none.view(), in_order));
  terrain.set_walked(walks.find(in_order));
  terrain.find_relief(in_order);
  terrain.visit(grid_in_vehicle(grid, {}), 0, grid.ny, [&](int ix, int iy, const CellGround& cell) {
    seen.elevation_m(ix, iy) = cell.elevation_m;
    seen.sigma_m(ix, iy) = cell.sigma_m;
    seen.kind(ix, iy) = cell.kind;
  });
  const View<const std::int16_t> rows{terrain.relief().rows};
  seen.relief = {rows.width, rows.height};
  for (int sector{0}; sector < rows.height; ++sector) {
    std::copy_n(rows.row(sector), rows.width, seen.relief.row(sector));
  }
  return seen;
}

inline Seen walked(const Vehicle& vehicle, const HeightField& height, bool has_errors) {
  Image<float> disparity{disparity_of(vehicle.rig, height)};
  if (has_errors) add_errors(0.25f, 7, disparity);
  return walked(vehicle, disparity);
}

struct Share {
  int of{0};
  int all{0};

  void add(bool is_one) {
    ++all;
    of += is_one ? 1 : 0;
  }
  [[nodiscard]] double value() const { return all > 0 ? static_cast<double>(of) / all : -1; }
};

/// Calls visit(ix, iy, place) for the cells in view between two ranges.
template <class Visit>
void for_cells(const Vehicle& vehicle, double from_m, double to_m, const Visit& visit) {
  for (const auto [ix, iy] : raster(vehicle.grid.nx, vehicle.grid.ny)) {
    const Point2 place{vehicle.grid.centre(ix, iy)};
    if (place.x >= from_m && place.x < to_m && std::abs(place.y) < 0.6 * place.x) visit(ix, iy, place);
  }
}

inline double drivable_share(const Vehicle& vehicle, const Seen& seen, double from_m, double to_m) {
  Share share;
  for_cells(vehicle, from_m, to_m,
            [&](int ix, int iy, Point2) { share.add(seen.kind(ix, iy) == TerrainClass::drivable); });
  return share.value();
}

/// Share of the grid's rows with a cell of `kind` within the margin of `x`.
inline double marked_share(const Vehicle& vehicle, const Seen& seen, double x, TerrainClass kind) {
  Share share;
  for (int iy{0}; iy < vehicle.grid.ny; ++iy) {
    if (std::abs(vehicle.grid.centre(0, iy).y) > 0.5 * x) continue;
    bool is_marked{false};
    for (int ix{0}; ix < vehicle.grid.nx; ++ix) {
      const bool is_near{std::abs(vehicle.grid.centre(ix, iy).x - x) < vehicle.margin_m + vehicle.grid.cell_size_m};
      is_marked = is_marked || (is_near && seen.kind(ix, iy) == kind);
    }
    share.add(is_marked);
  }
  return share.value();
}

inline HeightField ramp(float foot_m, float degrees) {
  return [=](float x, float) { return std::max(x - foot_m, 0.0f) * tangent_of(degrees); };
}

inline HeightField step(float at_m, float rise_m) {
  return [=](float x, float) { return x < at_m ? 0.0f : rise_m; };
}

inline HeightField ditch(float at_m, float width_m) {
  return [=](float x, float) { return x > at_m && x < at_m + width_m ? -0.8f : 0.0f; };
}

inline HeightField stairs(float at_m, float rise_m) {
  return [=](float x, float) { return x < at_m ? 0.0f : rise_m * std::min(8.0f, 1 + std::floor((x - at_m) / 0.3f)); };
}

}  // namespace stereogrid::test
