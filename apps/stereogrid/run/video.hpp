// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "stereogrid/io/image_file.hpp"

namespace stereogrid::app {

/// An H.264 film, encoded by the program ffmpeg. It gets its name when it is whole.
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
  void start(int width, int height);
  [[nodiscard]] bool stop();

  std::filesystem::path file_;
  std::filesystem::path unfinished_;
  double rate_hz_;
  int pipe_{-1};
  pid_t ffmpeg_{-1};
};

}  // namespace stereogrid::app
