// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/io/ffmpeg.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::app {

/// Arguments of ffmpeg for a file: an animated image for the endings .gif and .webp, no wider than 960 px, else H.264.
[[nodiscard]] std::vector<std::string> encoder_of(const std::filesystem::path& file);

/// A film, encoded by the program ffmpeg. It gets its name when it is whole.
class Video {
 public:
  /// Throws DeviceError: ffmpeg is missing, the folder cannot be written.
  Video(const std::filesystem::path& file, double rate_hz);
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;
  /// Without finish(): nothing is left.
  ~Video();

  /// Adds an image. All have the size of the first; an odd last row or column is left out. Throws DeviceError.
  void add(const io::RgbImage& picture);
  /// Throws DeviceError where ffmpeg has failed.
  void finish();

 private:
  std::filesystem::path file_;
  std::filesystem::path unfinished_;
  double rate_hz_;
  std::optional<io::Ffmpeg> ffmpeg_;
};

}  // namespace stereogrid::app
