// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"
#include "observation/projection/model.hpp"
#include "observation/projection/projection.hpp"

namespace stereogrid {

/// Working memory of `project` on the device.
struct ProjectionOnDevice {
  ProjectionOnDevice(int width, int disparities);

  DeviceImage<float> of_2;  ///< (D, W) maximum over 2 columns from u on
  DeviceImage<float> of_4;
  DeviceImage<float> of_8;
};

/// Before the first `project` of a frame.
void find_largest(Cuda& cuda, View<const float, Device> occupancy, ProjectionOnDevice& space);

/// `project` of projection.hpp, equal to the CPU to the bit. `grid` is on the device.
void project(Cuda& cuda, View<const float, Device> occupancy, const BinGeometry& bins, const GridInVehicle* grid,
             const ProjectionOnDevice& space, View<float, Device> cells);

}  // namespace stereogrid
