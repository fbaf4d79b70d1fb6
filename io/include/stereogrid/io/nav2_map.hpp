// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::io {

/// Writes a grid as a map that Nav2's map_server loads: `yaml` (NAME.yaml) and NAME.pgm beside it. Cells are occupied,
/// free or unknown as OccupancyScale::trinary has them, and come back so. The map's frame is the one that `geometry` is
/// given in: FrameResult::world for a map that stays, FrameResult::vehicle for one that moves along. Velocities and
/// ages are not part of such a map.
///
/// Throws InputError: `occupancy` does not have the geometry's size, or there are no cells, or `yaml` does not end in
/// .yaml or .yml; DeviceError: a file cannot
/// be written.
STEREOGRID_EXPORT void write_nav2_map(const std::filesystem::path& yaml, const GridGeometry& geometry,
                                      View<const float> occupancy);

}  // namespace stereogrid::io
