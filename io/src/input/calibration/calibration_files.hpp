// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace stereogrid::io {

/// Two files that are named alike: with "left" and "right", or "intrinsic" and "extrinsic", in the name of the file,
/// else in that of its folder.
struct FilePair {
  std::filesystem::path first;
  std::filesystem::path second;
};

/// Left and right file, of which `either` is one. Throws InputError: the name has no counterpart, or it does not exist.
[[nodiscard]] FilePair left_and_right(const std::filesystem::path& either);

/// The same for OpenCV's intrinsics.yml and extrinsics.yml.
[[nodiscard]] FilePair intrinsics_and_extrinsics(const std::filesystem::path& either);

/// The second camera of a EuRoC folder is the left one, as both T_BS say. False where they cannot be read.
[[nodiscard]] bool is_cam0_right(const std::filesystem::path& cam0, const std::filesystem::path& cam1);

/// Calibration file of another tool in a folder: LEFT.yaml there, in camera_info/ or as left/camera_info.yaml or
/// left/ost.yaml, extrinsics.yml, camchain.yaml, or any file of a supported format, there or in calib/, calibration/ or
/// intrinsic/. `has_depth`: one camera is enough. Empty: none. Throws InputError where there are several.
[[nodiscard]] std::filesystem::path find_calibration_in(const std::filesystem::path& folder, bool has_depth = false);

}  // namespace stereogrid::io
