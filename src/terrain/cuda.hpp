// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "backend/cuda.hpp"
#include "stereogrid/camera.hpp"
#include "terrain/rules.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

/// Terrain's data on the device. Allocated once.
struct TerrainOnDevice {
  /// Elements of `medians`.
  static std::size_t medians_of(const Rig& rig) {
    return static_cast<std::size_t>(terrain_sectors(rig.width_px)) * static_cast<std::size_t>(rig.height_px);
  }
  /// `has_terrain` false: all is empty. `medians_at`: memory of the medians.
  TerrainOnDevice(const Rig& level_rig, bool has_terrain, float* medians_at)
      : medians{has_terrain ? level_rig.height_px : 0, terrain_sectors(level_rig.width_px), medians_at} {}

  DeviceImage<float> medians;  ///< (row, sector), px
};

/// Medians of all sectors in all rows, as on the CPU.
void find_medians(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                  TerrainOnDevice& terrain);

/// Applies rules, row by row without gaps, to `cells`. `rules` is on the device, or in pinned memory.
void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells);

}  // namespace stereogrid
