// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/cuda.hpp"

namespace stereogrid {

/// LayersOnDevice, as a kernel takes them.
struct LayerPointers {
  float* occupancy;
  float* velocity_x;
  float* velocity_y;
  float* age_s;
  float* velocity_xx;
  float* velocity_xy;
  float* velocity_yy;
  float* moving;
};

inline LayerPointers pointers(const LayersOnDevice& layers) {
  const auto of = [](const DeviceImage<float>& layer) { return const_cast<float*>(layer.data()); };
  return {of(layers.occupancy),   of(layers.velocity_x),  of(layers.velocity_y),  of(layers.age_s),
          of(layers.velocity_xx), of(layers.velocity_xy), of(layers.velocity_yy), of(layers.moving)};
}

__device__ inline void write_velocity(const VelocityEstimate& velocity, int i, const LayerPointers& layers) {
  layers.velocity_x[i] = velocity.x;
  layers.velocity_y[i] = velocity.y;
  layers.velocity_xx[i] = velocity.xx;
  layers.velocity_xy[i] = velocity.xy;
  layers.velocity_yy[i] = velocity.yy;
}

}  // namespace stereogrid
