// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "figures/lidar_points.hpp"
#include "figures/panels.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::app::figures {

/// Lidar returns from above, coloured by height, on the axes of a grid.
[[nodiscard]] Panel scan_panel(std::string title, const std::vector<LidarPoint>& scan, const GridGeometry& grid,
                               const Rig& rig);

/// What a built-in scene truly has in the cells, and what the camera can see of it.
[[nodiscard]] Panel truth_panel(std::string title, const FrameTruth& truth, const GridGeometry& grid, const Rig& rig);

}  // namespace stereogrid::app::figures
