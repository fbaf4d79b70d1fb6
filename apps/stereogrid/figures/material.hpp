// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "figures/lidar_points.hpp"
#include "input.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::app::figures {

/// A frame and what the pipeline made of it.
struct Moment {
  StereoFrame frame;
  FrameResult result;
};

/// What another configuration made of the figures' frame.
struct Variant {
  UDisparityConfig config;
  Image<float> observed;   ///< the frame alone
  Image<float> occupancy;  ///< filtered
};

/// All that the figures show.
struct Material {
  std::string input;
  Config config;  ///< resolved
  Rig rig;
  std::vector<Moment> moments;  ///< in time order; the last is the figures' own
  Variant without_gaussian;
  std::vector<Variant> error_rates;             ///< P_FP = P_FN = 0.01, 0.1, 0.3
  std::optional<std::vector<LidarPoint>> scan;  ///< none: the frame has no lidar sweep
  std::optional<FrameTruth> truth;              ///< of a built-in scene, on the same cells as the grid
  int frames_before{0};                         ///< that the filter has seen

  [[nodiscard]] const Moment& moment() const { return moments.back(); }
};

/// The place of a frame in the input. "": the middle one, or the nearest to it that has a lidar sweep. Throws
/// ConfigError for an unknown name.
[[nodiscard]] std::size_t frame_index(const Input& input, const std::string& name);

/// Takes up to 20 frames before the frame, and the frame, through the pipeline and its variants. Throws InputError
/// where the frame cannot be used.
[[nodiscard]] Material gather(const Input& input, std::size_t index, const Config& config);

}  // namespace stereogrid::app::figures
