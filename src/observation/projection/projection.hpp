// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "memory_bytes.hpp"
#include "observation/projection/model.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// Bins begin … end of disparity d.
struct BinSpan {
  std::int16_t d;
  std::int16_t begin;
  std::int16_t end;
};

/// Working memory of `project`, and the bins of the cells of a grid that is fixed in the vehicle frame.
struct ProjectionWorkspace {
  static constexpr int levels{3};

  ProjectionWorkspace(int width, int disparities);
  /// Takes this grid as the one that stays: the next projections to it need no geometry. Allocates.
  void plan(const BinGeometry& bins, const GridInVehicle& grid);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(largest, first_span, spans); }

  std::vector<Image<float>> largest;  ///< [k] (D, W) largest occupancy of the 2^(k+1) columns from u on
  GridInVehicle planned{};
  std::vector<std::size_t> first_span;  ///< [cell], and the end of the last
  std::vector<BinSpan> spans;
};

/// u-disparity occupancy to a Cartesian grid (eq. 16): a cell takes the largest occupancy of the bins whose footprint
/// (depth [f·b/(d+½), f·b/(d−½)], columns u ± ½) shares an area with it, 0.5 where none does. `occupancy` is (D, W);
/// the grid may lie anywhere in the vehicle frame. `bins` are those that `space` was planned for, if it was.
void project(Cpu& cpu, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             ProjectionWorkspace& space, View<float> cells);
void project(Reference& reference, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             ProjectionWorkspace& space, View<float> cells);

}  // namespace stereogrid
