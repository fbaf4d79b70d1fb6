// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "input.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::app {

/// The lidar sweeps of a recording, in the left camera's frame.
class Sweeps {
 public:
  /// `recording`: may be none, as of a scene; it must outlive this.
  explicit Sweeps(const io::Recording* recording) : recording_{recording} {}

  /// True if there are sweeps with a known position of the lidar.
  [[nodiscard]] bool exist() const;
  /// Throws InputError where they do not; `instead` is what would mend that a recording has none.
  void require(const std::string& instead) const;

  /// Points of a frame, in the sensor's order; empty: none. Throws InputError; DeviceError if a listed file cannot be
  /// read now.
  [[nodiscard]] std::vector<evaluation::CameraPoint> of(std::size_t index) const;
  /// Position of the lidar.
  [[nodiscard]] evaluation::CameraPoint lidar_in_camera() const;

 private:
  const io::Recording* recording_;
};

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
