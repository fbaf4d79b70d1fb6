// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "stereogrid/config.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Vehicle-frame grid of a configuration.
GridGeometry vehicle_grid_of(const GridConfig& config);

/// Allocates the images that do not have their size; the others are left as they are.
void make_room(const Config& config, const Rig& level_rig, StageImages& stages);
/// The same for grids and predictions.
void make_room(const Config& config, const std::vector<double>& horizons_s, FrameResult& result);

/// Begins a frame of a further camera's result: allocates its grids, which are unknown, without status and warnings.
void begin_camera(const Config& config, FrameResult& seen);

/// Obstacle disparities of a frame, and which of their pixels are ambiguous. `matched` may be the result's own image.
void set_obstacles(View<const float> matched, StageImages& stages);

/// A result with all its images allocated, without predictions.
FrameResult empty_result(const Config& config, const Rig& level_rig);

/// Share of the pixels that have a disparity.
double share_matched(const Image<float>& disparity);

std::size_t memory_bytes(const GridLayers& layers);
std::size_t memory_bytes(const StageImages& stages);
std::size_t memory_bytes(const FrameResult& result);

}  // namespace stereogrid
