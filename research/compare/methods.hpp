// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "baselines/baselines.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/opencv_matcher.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::research {

/// Input of every method of a comparison for a frame.
struct ComparedFrame {
  DisparityFrame disparities;
  GridGeometry grid;
  Pose2 world_from_vehicle;
  std::vector<evaluation::CameraPoint> sweep;  ///< empty: none
  evaluation::CameraPoint lidar;               ///< position of the sensor
  double camera_height_m{0};                   ///< start of the search for the lidar's road
};

/// A way to make a grid of a frame. Exactly one of `config` and `grid_of` is set.
struct CompareMethod {
  std::string name;
  std::string title;
  bool over_time{false};
  std::optional<Config> config{};  ///< this library's pipeline; the grid that is filtered where over_time
  std::function<Image<float>(const ComparedFrame&)> grid_of{};
  bool fuses_lidar{false};  ///< the pipeline also receives the lidar's grid
};

/// All methods, this library's first; `only`: those of these names. `with_lidar`: the input has sweeps. Throws
/// ConfigError for an unknown name.
[[nodiscard]] std::vector<CompareMethod> compare_methods(const Config& config, bool with_lidar,
                                                         const std::vector<std::string>& only);

/// Matches with OpenCV before the pipeline does.
class OpencvStage {
 public:
  /// `name`: "own" (nothing to do), "opencv-bm" or "opencv-sgbm".
  OpencvStage(const std::string& name, int disparities);

  /// Replaces the frame's right image by OpenCV's disparities.
  void match(StereoFrame& frame) const;

 private:
  std::optional<io::OpencvMatcher> matcher_;
  int disparities_;
};

}  // namespace stereogrid::research
