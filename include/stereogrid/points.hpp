// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// What a measured point belongs to; the numbers are those of TruthLabel.
enum class PointLabel : std::uint8_t { road = 1, obstacle = 2 };

/// A measured point in the vehicle frame. x and y are where the grids have it; z is the height above the plane of
/// FrameResult::ground, nearly 0 for points of the road.
struct LabelledPoint {
  float x_m{0};
  float y_m{0};
  float z_m{0};
  PointLabel label{PointLabel::road};
};

/// The points of all pixels that have a disparity, row by row from the upper left one. None of a frame whose matches or
/// whose road are not to be relied on (FrameStatus::few_matches, road_unknown). `level_rig`: FrameResult::level_rig.
/// Throws InputError: the result has no stages (PipelineOptions::stages), or they are not of that rig.
[[nodiscard]] STEREOGRID_EXPORT std::vector<LabelledPoint> points_of(const FrameResult& result, const Rig& level_rig);

}  // namespace stereogrid
