// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "input/calibration/yaml_group.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// What is known beside a calibration file.
struct CalibrationRequest {
  int width_px{0};  ///< of the images, 0: not known
  int height_px{0};
  KittiPair pair{KittiPair::grey};
  // of the calibration.yaml that names the file with 'from'
  bool is_named{false};
  bool has_stated_size{false};  ///< width and height are those that it states
  std::optional<bool> images_are_raw{};
  std::optional<double> baseline_m{};
};

// The readers throw InputError: no such file, keys missing, values that are no numbers, cameras that are none. The
// caller looks for `problems` of the rig.

/// Any file that other tools write, or calibration.yaml, told apart by content. `paths`: one file, or left and right.
[[nodiscard]] Calibration read_form(const std::vector<std::filesystem::path>& paths, const CalibrationRequest& request);

/// Either form of calibration.yaml, or one that names a file of another tool.
[[nodiscard]] Calibration read_own_calibration(const YamlGroup& root, const std::filesystem::path& path,
                                               const CalibrationRequest& request);
[[nodiscard]] Calibration read_kitti_calibration(const std::filesystem::path& path, KittiPair pair);
[[nodiscard]] Calibration read_ros_calibration(const YamlGroup& left, const YamlGroup& right,
                                               const CalibrationRequest& request);
/// Both may be the same file.
[[nodiscard]] Calibration read_opencv_calibration(const YamlGroup& intrinsics, const YamlGroup& extrinsics,
                                                  const CalibrationRequest& request);
[[nodiscard]] Calibration read_kalibr_calibration(const YamlGroup& root, const CalibrationRequest& request);

}  // namespace stereogrid::io
