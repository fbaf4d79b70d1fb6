// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "stereogrid/grid.hpp"
#include "stereogrid/points.hpp"

namespace stereogrid::messages {

/// Voxel filter with memory that is reused.
class VoxelFilter {
 public:
  /// Most points of a filtered cloud: 0.13 MB with 16 bytes each, which Linux's default receive buffer of 0.2 MB holds.
  static constexpr std::size_t points_max{8'000};

  /// Keeps the first point of each label in each voxel, within the sides of `grid` (vehicle frame). The side of the
  /// voxels, `voxel_m`, is doubled until at most `points_max` points remain. 0: keeps all points.
  void apply(std::vector<LabelledPoint>& points, const GridGeometry& grid, double voxel_m);

 private:
  void keep_first_of_each(std::vector<LabelledPoint>& points, double voxel_m);

  std::vector<std::uint64_t> voxels_;  // hash set with open addressing
};

}  // namespace stereogrid::messages
