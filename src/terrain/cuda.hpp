// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "backend/cuda.hpp"
#include "stereogrid/camera.hpp"
#include "terrain/rules.hpp"
#include "terrain/samples.hpp"
#include "terrain/trenches.hpp"

namespace stereogrid {

/// Terrain's data on the device. Allocated once.
struct TerrainOnDevice {
  /// Elements of `medians`.
  static std::size_t medians_of(const Rig& rig) {
    return static_cast<std::size_t>(terrain_sectors(rig.width_px)) * static_cast<std::size_t>(rig.height_px);
  }
  /// `has_terrain` false: without what depends on the image's size. `medians_at`: memory of the medians.
  TerrainOnDevice(Cuda& cuda, const Rig& level_rig, int window_px, bool has_terrain, float* medians_at);

  int trench_margin;           ///< rows of ground around a trench
  DeviceImage<float> medians;  ///< (row, sector), px
  DeviceBuffer<TrenchShape> shapes;
  DeviceBuffer<std::optional<Trench>> trenches;  ///< by sector
  PinnedBuffer<std::optional<Trench>> found;     ///< the same on the host
};

/// Medians of all sectors in all rows, as on the CPU.
void find_medians(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                  TerrainOnDevice& terrain);

/// Trenches in the medians, as TrenchFilter::find_all(), to terrain.found.
void find_trenches(Cuda& cuda, const SampledGround& ground, TerrainOnDevice& terrain);

/// Applies rules, row by row without gaps, to `cells`. `rules` is on the device, or in pinned memory.
void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells);

}  // namespace stereogrid
