// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

enum class InputKind { kitti_odometry, kitti_raw, euroc, plain_folder, image_pair };

/// Paths of the parts of an input; empty if missing.
struct InputLayout {
  InputKind kind{InputKind::plain_folder};
  std::filesystem::path root;
  std::filesystem::path left;  ///< folder of images, or the image itself
  std::filesystem::path right;
  std::filesystem::path calibration;
  std::filesystem::path scans;
  KittiPair pair{KittiPair::grey};
  std::filesystem::path disparities{};  ///< folder that stands in for the right images
  bool is_shared{false};                ///< each image shows both cameras; `left` is the folder of all
  bool with_right{false};               ///< `disparities` come beside the right images
};

/// "KITTI odometry sequence" and so on.
[[nodiscard]] std::string name_of(InputKind kind);

/// Recognises an input. `disparities`: a folder to take instead of right images; none: that of a plain folder without
/// right images. Throws InputError: nothing there, or nothing that is known.
[[nodiscard]] InputLayout recognise(const std::vector<std::filesystem::path>& paths,
                                    const std::optional<std::filesystem::path>& disparities);

/// Depth, not disparities, by the folder's name.
[[nodiscard]] bool is_depth_folder(const std::filesystem::path& folder);

/// The frames, left images paired by name with right or disparity images; a frame one of whose images is missing is
/// marked. Throws InputError: no images, no pair.
[[nodiscard]] std::vector<RecordedFrame> find_frames(const InputLayout& layout);

}  // namespace stereogrid::io
