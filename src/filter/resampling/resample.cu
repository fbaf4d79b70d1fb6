// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "filter/layers.cuh"
#include "filter/resampling/resample_model.hpp"

namespace stereogrid {
namespace {

constexpr int cells_width{32};
constexpr int cells_height{8};

// A thread per cell of the vehicle's grid.
__global__ void resample_cells(LayerPointers world, const GridGeometry* window, const GridInVehicle* vehicle_in_world,
                               View<float, Device> occupancy, LayerPointers out) {
  const int ix{static_cast<int>(blockIdx.x * cells_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * cells_height + threadIdx.y)};
  if (ix >= occupancy.width || iy >= occupancy.height) return;
  const int to{iy * occupancy.width + ix};
  const CellPlaces cells{places_in_window(*vehicle_in_world, *window)};
  const float x{cells.x_of(ix, iy)};
  const float y{cells.y_of(ix, iy)};
  const int nx{window->nx};
  const bool is_within{is_inside(*window, x, y)};
  const auto smooth = [&](const float* layer) {
    const auto value = [&](int cx, int cy) { return layer[cy * nx + cx]; };
    return interpolated(value, nx, window->ny, x - 0.5f, y - 0.5f);
  };
  VelocityEstimate velocity{};
  const int from{is_within ? static_cast<int>(y) * nx + static_cast<int>(x) : 0};
  if (is_within) {
    velocity = turned({world.velocity_x[from], world.velocity_y[from], world.velocity_xx[from], world.velocity_xy[from],
                       world.velocity_yy[from]},
                      static_cast<float>(vehicle_in_world->cos_yaw), static_cast<float>(vehicle_in_world->sin_yaw));
  }
  out.occupancy[to] = is_within ? smooth(world.occupancy) : 0.5f;
  out.moving[to] = is_within ? smooth(world.moving) : 0.0f;
  out.age_s[to] = is_within ? world.age_s[from] : INFINITY;
  out.velocity_x[to] = velocity.x;
  out.velocity_y[to] = velocity.y;
  out.velocity_xx[to] = velocity.xx;
  out.velocity_xy[to] = velocity.xy;
  out.velocity_yy[to] = velocity.yy;
}

}  // namespace

LayersOnDevice::LayersOnDevice(int width, int height, float* memory)
    : LayersOnDevice{width, height, memory, memory == nullptr ? floats_of(width, height) : 0} {}

LayersOnDevice::LayersOnDevice(int width, int height, float* memory, std::size_t own_floats)
    : own_{own_floats},
      occupancy{width, height, memory == nullptr ? own_.data() : memory},
      velocity_x{width, height, occupancy.data() + occupancy.size()},
      velocity_y{width, height, velocity_x.data() + occupancy.size()},
      age_s{width, height, velocity_y.data() + occupancy.size()},
      velocity_xx{width, height, age_s.data() + occupancy.size()},
      velocity_xy{width, height, velocity_xx.data() + occupancy.size()},
      velocity_yy{width, height, velocity_xy.data() + occupancy.size()},
      moving{width, height, velocity_yy.data() + occupancy.size()} {}

void resample(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window,
              const GridInVehicle* vehicle_in_world, LayersOnDevice& vehicle) {
  const int nx{vehicle.occupancy.width()};
  const int ny{vehicle.occupancy.height()};
  launch(cuda, resample_cells, dim3{blocks_for(nx, cells_width), blocks_for(ny, cells_height)},
         dim3{cells_width, cells_height}, 0, pointers(world), window, vehicle_in_world, vehicle.occupancy.view(),
         pointers(vehicle));
}

}  // namespace stereogrid
