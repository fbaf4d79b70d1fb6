// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "input.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid::app {

/// Findings from some frames of a camera.
struct Look {
  std::string camera;  ///< name of one of several cameras
  std::size_t looked_at{0};
  std::size_t usable{0};                  ///< could be loaded
  std::size_t tried{0};                   ///< frames processed by the pipeline
  std::size_t road_found{0};              ///< in frames tried
  std::optional<double> row_residual_px;  ///< median over frames of io::row_residual_px()
  Ground road;                            ///< medians where it was found; pitch of the images as they came
  Rig rig;                                ///< with the extrinsics that a run would use after these frames
  std::string mount;        ///< estimated extrinsics as a line for calibration.yaml; empty: none replaced the input's
  bool is_hopeless{false};  ///< nothing that can be used would come of a run
  std::vector<std::string> problems;
};

struct Looks {
  std::vector<Look> cameras;
  std::vector<std::string> problems;  ///< problems that are not of one camera
};

/// Loads `count` frames spread over the input, and takes a few of them, the first ones and some of the others, through
/// the pipeline, for a few seconds at most. Says in plain words what is wrong and what would mend it, for each camera.
[[nodiscard]] Looks look_at_frames(const Input& input, const Config& config, std::size_t count);

}  // namespace stereogrid::app
