// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "stereogrid/config.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// The vehicle-frame grid that a configuration asks for.
GridGeometry vehicle_grid_of(const GridConfig& config);

/// A result with all its images allocated.
FrameResult empty_result(const Config& config, const Rig& level_rig);

/// Rows of the u-disparity images.
int bins_of(const Config& config);

/// Share of the pixels that have a disparity.
double share_matched(const Image<float>& disparity);

std::size_t held_bytes(const GridLayers& layers);
std::size_t held_bytes(const StageImages& stages);
std::size_t held_bytes(const FrameResult& result);

}  // namespace stereogrid
