// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/filter.hpp"
#include "filter/resampling/resample_model.hpp"

namespace stereogrid {
namespace {

constexpr float never{std::numeric_limits<float>::infinity()};

// At a place in cells from the corner of the first.
float smooth_value(const Image<float>& cells, float x, float y) {
  const auto at = [&](int ix, int iy) { return cells(ix, iy); };
  return interpolated(at, cells.width(), cells.height(), x - 0.5f, y - 0.5f);
}

// From the window to vehicle axes.
class Resampler {
 public:
  Resampler(const Pose2& world_from_vehicle, FrameResult& result)
      : world_{result.world},
        to_{result.vehicle},
        c_{static_cast<float>(std::cos(world_from_vehicle.yaw_rad))},
        s_{static_cast<float>(std::sin(world_from_vehicle.yaw_rad))} {}

  // Vehicle cell (ix, iy) from the place (x, y) of its centre, in cells of the window.
  void fill(int ix, int iy, float x, float y) const {
    if (!is_inside(world_.geometry, x, y)) return fill_outside(ix, iy);
    to_.occupancy(ix, iy) = smooth_value(world_.occupancy, x, y);
    to_.moving(ix, iy) = smooth_value(world_.moving, x, y);
    fill_nearest(ix, iy, static_cast<int>(x), static_cast<int>(y));
  }

 private:
  void fill_outside(int ix, int iy) const {
    to_.occupancy(ix, iy) = 0.5f;
    to_.age_s(ix, iy) = never;
    to_.moving(ix, iy) = to_.velocity_x(ix, iy) = to_.velocity_y(ix, iy) = 0;
    to_.velocity_xx(ix, iy) = to_.velocity_xy(ix, iy) = to_.velocity_yy(ix, iy) = 0;
  }

  void fill_nearest(int ix, int iy, int x, int y) const {
    to_.age_s(ix, iy) = world_.age_s(x, y);
    const VelocityEstimate v{turned({world_.velocity_x(x, y), world_.velocity_y(x, y), world_.velocity_xx(x, y),
                                     world_.velocity_xy(x, y), world_.velocity_yy(x, y)},
                                    c_, s_)};
    to_.velocity_x(ix, iy) = v.x;
    to_.velocity_y(ix, iy) = v.y;
    to_.velocity_xx(ix, iy) = v.xx;
    to_.velocity_xy(ix, iy) = v.xy;
    to_.velocity_yy(ix, iy) = v.yy;
  }

  const GridLayers& world_;
  GridLayers& to_;
  float c_;
  float s_;
};

// Calls work(ix, iy, x, y) for each cell of the vehicle's grid and the place of its centre, in cells of the window.
template <class Work>
void for_vehicle_cells(const GridGeometry& window, const Pose2& world_from_vehicle, const GridGeometry& grid,
                       const Work& work) {
  const CellPlaces cells{places_in_window(grid_in_vehicle(grid, world_from_vehicle), window)};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) work(ix, iy, cells.x_of(ix, iy), cells.y_of(ix, iy));
  }
}

}  // namespace

void resample(const Pose2& world_from_vehicle, FrameResult& result) {
  const Resampler resampler{world_from_vehicle, result};
  for_vehicle_cells(result.world.geometry, world_from_vehicle, result.vehicle.geometry,
                    [&](int ix, int iy, float x, float y) { resampler.fill(ix, iy, x, y); });
}

void complete_unobserved(const Pose2& world_from_vehicle, FrameResult& result) {
  const GridLayers& world{result.world};
  GridLayers& vehicle{result.vehicle};
  const CellPlaces cells{places_in_window(grid_in_vehicle(vehicle.geometry, world_from_vehicle), world.geometry)};
  const auto age_at = [&](int ix, int iy) { return world.age_s(ix, iy); };
  for (int iy{0}; iy < vehicle.geometry.ny; ++iy) {
    float* const age_s{vehicle.age_s.row(iy)};
    float* const occupancy{vehicle.occupancy.row(iy)};
    const auto stays = [&](int first) {
      return !any_of_group(first, [&](int ix) { return may_complete(age_s[ix], occupancy[ix]); });
    };
    for_groups(vehicle.geometry.nx, stays, [&](int ix) {
      complete_cell(age_at, world.geometry, cells.x_of(ix, iy), cells.y_of(ix, iy), vehicle.moving(ix, iy), age_s[ix],
                    occupancy[ix]);
    });
  }
}

void resample_occupancy(const GridLayers& world, const Pose2& world_from_vehicle, const GridGeometry& vehicle_grid,
                        Image<float>& occupancy) {
  const GridGeometry& window{world.geometry};
  for_vehicle_cells(window, world_from_vehicle, vehicle_grid, [&](int ix, int iy, float x, float y) {
    occupancy(ix, iy) = is_inside(window, x, y) ? smooth_value(world.occupancy, x, y) : 0.5f;
  });
}

}  // namespace stereogrid
