// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "accuracy/truth_points.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::bench {

/// Stereo pair with its truth. Images, points and plane are those of the level camera.
struct TruthFrame {
  StereoFrame frame;
  std::vector<TruthPoint> points;  ///< points that every matcher can find (keep_comparable)
  RoadPlane plane;                 ///< the road of the truth
};

/// Frames of one recording that have truth.
struct TruthSet {
  std::string name;
  std::string group;  ///< sets of one group share a table
  Rig rig;            ///< level, mounted as the calibration says
  int disparities{0};
  int sample_step{1};  ///< samples take every so manieth column and row of truth
  std::size_t frames{0};
  std::function<TruthFrame(std::size_t)> load;
};

/// The sets below the folder that can be measured: Velodyne drives, KITTI pairs, synthetic sequences. Those that are
/// not there are left out. Throws InputError where one is damaged.
std::vector<TruthSet> open_sets(const std::filesystem::path& data);

}  // namespace stereogrid::bench
