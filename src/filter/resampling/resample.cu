// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "filter/correction_model.hpp"
#include "filter/layers.cuh"

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

// The same for the cells of the frame's own grid.
__global__ void correct_cells(View<const float, Device> window_occupancy, const GridGeometry* window,
                              const GridInVehicle* cells, const GridInVehicle* vehicle_in_world,
                              View<const float, Device> observed, bool is_widened, LayerPointers vehicle) {
  const int ix{static_cast<int>(blockIdx.x * cells_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * cells_height + threadIdx.y)};
  if (ix >= observed.width || iy >= observed.height) return;
  const FrameCorrection<Device> correction{observed, window_occupancy, *cells,
                                           places_in_window(*vehicle_in_world, *window), is_widened};
  const int cell{iy * observed.width + ix};
  correction.correct(ix, iy, vehicle.occupancy[cell], vehicle.moving[cell]);
}

__global__ void complete_cells(View<const float, Device> window_age_s, const GridGeometry* window,
                               const GridInVehicle* vehicle_in_world, View<float, Device> age_s,
                               LayerPointers vehicle) {
  const int ix{static_cast<int>(blockIdx.x * cells_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * cells_height + threadIdx.y)};
  if (ix >= age_s.width || iy >= age_s.height) return;
  const CellPlaces cells{places_in_window(*vehicle_in_world, *window)};
  const int cell{iy * age_s.width + ix};
  complete_cell(window_age_s, *window, cells.x_of(ix, iy), cells.y_of(ix, iy), vehicle.moving[cell], age_s(ix, iy),
                vehicle.occupancy[cell]);
}

dim3 blocks_of(const DeviceImage<float>& cells) {
  return {blocks_for(cells.width(), cells_width), blocks_for(cells.height(), cells_height)};
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
  launch(cuda, resample_cells, blocks_of(vehicle.occupancy), dim3{cells_width, cells_height}, 0, pointers(world),
         window, vehicle_in_world, vehicle.occupancy.view(), pointers(vehicle));
}

void correct_by_frame(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window, const GridInVehicle* cells,
                      const GridInVehicle* vehicle_in_world, View<const float, Device> observed, bool is_widened,
                      LayersOnDevice& vehicle) {
  launch(cuda, correct_cells, blocks_of(vehicle.occupancy), dim3{cells_width, cells_height}, 0, world.occupancy.view(),
         window, cells, vehicle_in_world, observed, is_widened, pointers(vehicle));
}

void complete_unobserved(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window,
                         const GridInVehicle* vehicle_in_world, LayersOnDevice& vehicle) {
  launch(cuda, complete_cells, blocks_of(vehicle.occupancy), dim3{cells_width, cells_height}, 0, world.age_s.view(),
         window, vehicle_in_world, vehicle.age_s.view(), pointers(vehicle));
}

}  // namespace stereogrid
