// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::io {

// The .npz files of a frame; their arrays are listed in docs/format.md. Throw DeviceError.

/// The arrays that write_grids or write_compact_grids can write, but for world_origin, which comes with those of the
/// world, in the order of the file.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> grid_arrays(bool compact);

/// `layers`: some of grid_arrays(); none: all.
STEREOGRID_EXPORT void write_grids(const std::filesystem::path& path, const FrameResult& result,
                                   const std::vector<std::string>& layers = {});
/// The vehicle grid alone, in half as many bits: occupancies to 1/256, velocities to 1/16 m/s, ages to 1/64 s.
STEREOGRID_EXPORT void write_compact_grids(const std::filesystem::path& path, const FrameResult& result,
                                           const std::vector<std::string>& layers = {});
/// The frame must have predictions.
STEREOGRID_EXPORT void write_predictions(const std::filesystem::path& path, const FrameResult& result);
/// Writes every stage image that is not empty.
STEREOGRID_EXPORT void write_stages(const std::filesystem::path& path, const StageImages& stages);

}  // namespace stereogrid::io
