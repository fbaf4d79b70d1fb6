// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid::io {

/// Frames [first, end) of an input.
struct FrameRange {
  std::size_t first{0};
  std::size_t end{0};
};

/// Number of multiples of `every` from `first` to `last`, both included.
[[nodiscard]] constexpr std::size_t multiples_between(std::size_t first, std::size_t last, std::size_t every) {
  return last < first ? 0 : last / every + 1 - (first + every - 1) / every;
}

/// Input of a run.
struct RunInput {
  std::string kind;  ///< "scene": a built-in one
  std::vector<std::string> paths;
  std::string poses;                   ///< recordings: the file, "odometry", "": none; scenes: as requested
  std::string calibration;             ///< the file; of recordings only, as what follows
  std::string disparities;             ///< "": none were given
  std::string mask{};                  ///< the file, of scenes, too; "": none
  std::vector<std::string> cameras{};  ///< InputArguments::cameras
};

/// Description of a run before its first frame.
struct RunDescription {
  // Settings that affect the results; a resumed run must have the same ones.
  std::string preset;
  Config config;  ///< resolved
  RunInput input;
  std::string matcher;
  std::vector<double> predict_s;
  std::string fuse_source;
  std::string device;
  Rig rig;
  GridGeometry grid;        ///< grid of the vehicle-frame arrays
  GridGeometry world_grid;  ///< its origin moves
  // These may differ, but for the first frame.
  std::string simd_target;
  int threads{0};
  FrameRange frames;
  // Must be in common, too.
  bool compact{false};                      ///< write_compact_grids
  std::size_t every{1};                     ///< only frames whose place in the input is a multiple of it are written
  std::vector<std::string> layers{};        ///< arrays of grids/NAME.npz; none: all
  std::size_t warm_up{0};                   ///< frames before them that went through the pipeline, too
  std::vector<Rig> other_rigs{};            ///< rigs of the cameras after the first
  std::vector<std::string> camera_names{};  ///< names of several cameras
};

}  // namespace stereogrid::io
