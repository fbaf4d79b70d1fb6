// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/pipeline.hpp"

namespace stereogrid {

/// `config` with every "automatic" value for one of the cameras. A depth z = f·b/d has the standard deviation
/// z²·σ_d/(f·b).
Config resolved(Config config, std::span<const Rig> rigs, std::size_t camera, bool extrinsics_given);

/// Mask of a camera; empty: all pixels are used.
const Image<std::uint8_t>& mask_of(const PipelineOptions& options, std::size_t camera);

/// Name of one of several cameras.
std::string name_of_camera(const PipelineOptions& options, std::size_t camera);

/// True: the optical axis and both sides of the view pass through the vehicle's grid.
bool contains_view(const GridGeometry& grid, const Rig& rig);

/// Checksum of all that must be equal for a saved state to be loaded.
std::uint64_t settings_of(const Config& config, const std::vector<Rig>& rigs, const PipelineOptions& options);

}  // namespace stereogrid
