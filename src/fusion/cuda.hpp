// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "backend/cuda.hpp"
#include "fusion/model.hpp"
#include "observation/projection/model.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid {

/// A frame's grids of other sources, on the device.
class OtherGridsOnDevice {
 public:
  /// Input of the kernels. Its address is constant, so that a recorded graph reads the grids of each frame.
  struct List {
    int count;
    const OtherCells* grids;
  };

  OtherGridsOnDevice();
  /// Uploads them. Waits for the device and allocates where they are larger than all before.
  void take(Cuda& cuda, std::span<const ObservedGrid> others);
  [[nodiscard]] const List* list() const { return list_.data(); }

 private:
  DeviceBuffer<List> list_;
  DeviceBuffer<OtherCells> grids_;
  DeviceBuffer<float> cells_;
  std::vector<OtherCells> sent_;  // content of grids_
};

/// `fuse` of fusion.hpp, equal to the CPU to the bit; `grid` is on the device.
void fuse(Cuda& cuda, const OtherGridsOnDevice& others, const GridInVehicle* grid, const FusionConfig& config,
          View<float, Device> cells);

/// fuse_camera_rows() of all rows, equal to the CPU to the bit; up to cameras_max cameras.
void fuse_cameras(Cuda& cuda, std::span<const View<const float, Device>> cameras, View<float, Device> cells);

/// Raises `cells` to the occupancy of the held ones. `held` and `count` are on the device, or in pinned memory.
void hold(Cuda& cuda, const RetainedCell* held, const int* count, View<float, Device> cells);

}  // namespace stereogrid
