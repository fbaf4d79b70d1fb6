// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "input.hpp"
#include "stereogrid/frame.hpp"
#include "sweeps.hpp"

namespace stereogrid::app {

/// Beginning of the warnings of frames without a grid to fuse.
extern const char* const stereo_alone;

/// Stands before the pipeline where the recording's lidar is to be fused (`run --fuse lidar`).
class LidarStage {
 public:
  /// `grid`: where the lidar's grid is made. Throws InputError where it is `wanted` and the input has no sweeps.
  LidarStage(bool wanted, const Input& input, const GridGeometry& grid);

  /// Gives the frame the grid that an inverse sensor model makes of its sweep, the camera being mounted as `rig` says.
  /// Returns a warning where there is none: `stereo_alone` and the reason.
  [[nodiscard]] std::optional<std::string> add_grid(StereoFrame& frame, const Rig& rig) const;

 private:
  bool wanted_;
  Sweeps sweeps_;
  GridGeometry grid_;
};

}  // namespace stereogrid::app
