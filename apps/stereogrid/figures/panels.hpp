// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "figures/colour_map.hpp"
#include "figures/sheet.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app::figures {

/// Side of a grid's panel, about.
enum class GridSize : int { small = 300, large = 400 };

/// An image of the u-disparity plane (rows: disparities, columns as in the left image) in the colours of `bar`, given
/// as shares; the distance at the right. `disparities`: how many px all rows together cover.
[[nodiscard]] Panel u_disparity_panel(std::string title, const Image<float>& shares, ColourBar bar, const Rig& rig,
                                      int disparities);
/// The same for pixel counts.
[[nodiscard]] Panel count_panel(std::string title, const Image<std::uint16_t>& counts, const Rig& rig, int disparities);

/// Occupancy from above, in the vehicle frame.
[[nodiscard]] Panel grid_panel(std::string title, const Image<float>& occupancy, const GridGeometry& grid,
                               const Rig& rig, GridSize size);
/// Cells from above in other colours, given as shares; no colour bar.
[[nodiscard]] Panel cells_panel(std::string title, const Image<float>& shares, Colour (*colour)(double share),
                                const GridGeometry& grid, const Rig& rig, GridSize size);
/// The same axes around white paper of the same size, to be drawn upon.
[[nodiscard]] Panel empty_grid_panel(std::string title, const GridGeometry& grid, GridSize size);

/// The left image, as the stages saw it; pixels along both edges.
[[nodiscard]] Panel camera_panel(std::string title, const StereoFrame& frame, const Rig& rig);
/// The same with what is upright and what is free road in colour.
[[nodiscard]] Panel overlay_panel(std::string title, const StereoFrame& frame, const FrameResult& result,
                                  const Rig& rig);

/// How many of each column's road pixels have each disparity: (rows, W), over `disparities` px. The whole column counts
/// (docs/method.md §5.3); 0 is no measurement.
[[nodiscard]] Image<std::uint16_t> road_counts(const Image<float>& road_disparity, int rows, int disparities);

}  // namespace stereogrid::app::figures
