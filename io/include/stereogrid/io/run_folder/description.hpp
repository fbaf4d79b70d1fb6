// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid::io {

/// Frames [first, end) of an input.
struct FrameRange {
  std::size_t first{0};
  std::size_t end{0};
};

/// What a run is made from.
struct RunInput {
  std::string kind;  ///< "scene": a built-in one
  std::vector<std::string> paths;
  std::string poses;        ///< of a recording: the file, "odometry", "": none; of a scene: as asked for
  std::string calibration;  ///< the file; of recordings only, as what follows
  std::string disparities;  ///< "": none were given
  std::string mask{};       ///< the file, of scenes, too; "": none
};

/// What is known of a run before its first frame.
struct RunDescription {
  // A run that goes on must have these in common with its beginning: they decide about the results.
  std::string preset;
  Config config;  ///< resolved
  RunInput input;
  std::string matcher;
  std::vector<double> predict_s;
  std::string fuse_source;
  std::string fuse_rings;
  std::string device;
  Rig rig;
  GridGeometry grid;        ///< of the vehicle-frame arrays
  GridGeometry world_grid;  ///< its origin moves
  // These may differ, but for the first frame.
  std::string simd_target;
  int threads{0};
  FrameRange frames;
  bool compact{false};     ///< write_compact_grids; must be in common
  std::size_t warm_up{0};  ///< frames before them that went through the pipeline, too; must be in common
};

}  // namespace stereogrid::io
