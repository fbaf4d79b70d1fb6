// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "backend/cuda.hpp"
#include "obstacles/segmentation/columns.hpp"

namespace stereogrid {

/// Finds the nodes in an image of disparities, on the device. Equal to ColumnCounter to the bit, in any order.
class ColumnsOnDevice {
 public:
  ColumnsOnDevice(Cuda& cuda, const Rig& level_rig, const UDisparityConfig& heights, int disparities);

  /// Uploads the limits of a frame on `ground`.
  void put(Cuda& cuda, const Ground& ground);
  /// Enqueues the search. `obstacle`: (H, W) px, 0 = none.
  void count(Cuda& cuda, View<const float, Device> obstacle, const Relief<Device>& relief);
  /// Nodes of the last count(), when the device has finished it.
  [[nodiscard]] std::span<const ColumnNode> nodes() { return {nodes_.data(), nodes_.data() + *found_.data()}; }

 private:
  ColumnGeometry geometry_;
  DeviceBuffer<ColumnBin> bins_;
  PinnedBuffer<UprightRow> limits_;
  DeviceBuffer<UprightRow> limits_on_device_;
  DeviceBuffer<int> found_on_device_;
  PinnedBuffer<int> found_;
  PinnedBuffer<ColumnNode> nodes_;  ///< written from the device: they are few, and how many changes
};

}  // namespace stereogrid
