// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "input/recording_images.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

/// One video with both cameras' images in each frame, or one for each camera, whose frames are pairs by their place.
struct VideoPair {
  std::filesystem::path left;
  std::filesystem::path right;  ///< empty: both in `left`
};

/// The videos that `paths` name: themselves, or those in the folder. None: no videos, or not two of both cameras.
[[nodiscard]] std::optional<VideoPair> find_videos(const std::vector<std::filesystem::path>& paths);

/// Frames, stamps and size. `calibration` decides on the layout where it is not given; empty: none. Throws InputError.
[[nodiscard]] ForeignRecording open_videos(const VideoPair& videos, std::optional<ImageLayout> layout,
                                           const std::filesystem::path& calibration);

}  // namespace stereogrid::io
