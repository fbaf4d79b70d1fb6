// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "observation/projection/model.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// Adds what other sources have observed to `cells`, the stereo pair's P(occupied) on `grid`. Of another grid the cell
/// counts that holds the centre of ours; where it does not reach, it says nothing (IndependentPool).
/// Without other grids nothing is changed.
void fuse(Cpu& cpu, std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
          View<float> cells);
void fuse(Reference& reference, std::span<const ObservedGrid> others, const GridInVehicle& grid,
          const FusionConfig& config, View<float> cells);

/// P(occupied) of the place `at` by the other sources alone; 0.5: none says anything.
[[nodiscard]] double claimed(std::span<const ObservedGrid> others, Point2 at);

/// Rows [begin, end) of it.
void fuse_rows(std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
               View<float> cells, int begin, int end);

/// P(occupied) of rows [begin, end) by all cameras, 0.5 = unknown: see CameraPool. `cells` may be one of `cameras`.
void fuse_camera_rows(std::span<const View<const float>> cameras, int begin, int end, View<float> cells);

}  // namespace stereogrid
