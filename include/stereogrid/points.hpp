// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Label of a measured point; the numbers are those of TruthLabel.
enum class PointLabel : std::uint8_t { road = 1, obstacle = 2 };

/// Measured point in the vehicle frame. z is the height above the plane of FrameResult::ground (of several cameras each
/// one's own), nearly 0 for points of the road.
struct LabelledPoint {
  float x_m{0};
  float y_m{0};
  float z_m{0};
  PointLabel label{PointLabel::road};
};

/// Points of all pixels with a disparity, row by row from the upper left one, of several cameras one after the other.
/// None of cameras with FrameStatus::few_matches or road_unknown. `level_rig`: FrameResult::level_rig. Throws
/// InputError: the result has no stages (PipelineOptions::stages), or they are not of that rig.
[[nodiscard]] STEREOGRID_EXPORT std::vector<LabelledPoint> points_of(const FrameResult& result, const Rig& level_rig);

}  // namespace stereogrid
