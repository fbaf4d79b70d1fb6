// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

struct Size {
  int width_px{0};
  int height_px{0};

  auto operator<=>(const Size&) const = default;
};

/// The left images say how large and how deep the images of the recording are: a few of them where they are alike, else
/// most of many.
Size look_at_images(RecordingContents& contents);

/// The part of an image of this size that a camera has.
[[nodiscard]] Size size_of_part(Size whole, ImageLayout layout);

/// Layout of images of both cameras with this size: as `wanted`, else by the calibration, else by the aspect ratio.
/// `calibration` empty: none. Throws InputError: no layout, or several.
[[nodiscard]] ImageLayout find_layout(Size whole, std::optional<ImageLayout> wanted,
                                      const std::filesystem::path& calibration, const std::filesystem::path& images);

/// By its name or its first bytes.
[[nodiscard]] bool is_video(const std::filesystem::path& file);
[[nodiscard]] bool has_video_extension(const std::filesystem::path& file);

/// Throws InputError where there are videos among the files, and names them.
void refuse_videos(std::span<const std::filesystem::path> files);

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

/// The folders of several stereo pairs as one recording: InputArguments::cameras, else 'cameras' of calibration.yaml.
/// Poses beside the folders are all cameras'. nullptr: another input. Throws InputError for a camera without a mount,
/// ConfigError for options that belong to one camera.
[[nodiscard]] std::unique_ptr<Recording> open_camera_folders(InputArguments arguments);

}  // namespace stereogrid::io
