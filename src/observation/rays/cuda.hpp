// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"
#include "geometry/relief.hpp"
#include "matching/cuda.hpp"
#include "observation/rays/model.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid {

/// Working memory and result of `count_rays` on the device.
struct RaysOnDevice {
  /// `disparities` 0: nothing, for configurations that do without.
  RaysOnDevice(int width, int height, int disparities, bool has_relief = false);

  /// Empty, unless the constructor has received one.
  [[nodiscard]] Relief<Device> relief_view() const {
    return {{relief.data(), relief.size() == 0 ? 0 : bins, relief_sectors(width), bins}};
  }
  [[nodiscard]] RaySums<Device> view() const { return {sums.data(), bins + 1, width + 1, bins + 1}; }

  int width;
  int height;
  int bins;
  int margin;
  DeviceBuffer<std::int32_t> shift;
  DeviceBuffer<RayRow> rows;
  DeviceBuffer<UprightRange> upright;
  DeviceBuffer<std::int16_t> relief;
  DeviceBuffer<PackedRays> sums;  ///< (W + 1, bins + 1)
};

/// `count_rays` and `project_rays` of rays.hpp, equal to the CPU to the bit where the tables of rows are. `ground`,
/// `grid` and `blur_px` are on the device. begin_rays() needs neither matches nor relief.
void begin_rays(Cuda& cuda, const Rig& rig, const Ground* ground, const UDisparityConfig& config, RaysOnDevice& space);
void count_rays(Cuda& cuda, const MatchViews& matches, RaysOnDevice& space);
void project_rays(Cuda& cuda, const RaysOnDevice& space, const BinGeometry& geometry, const GridInVehicle* grid,
                  const float* blur_px, View<float, Device> cells);

}  // namespace stereogrid
