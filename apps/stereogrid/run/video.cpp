// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/video.hpp"

#include <fmt/format.h>

#include <csignal>
#include <string>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app {

Video::Video(const std::filesystem::path& file, double rate_hz)
    : file_{file},
      unfinished_{file.parent_path() /
                  fmt::format(".{}.unfinished{}", file.stem().string(), file.extension().string())},
      rate_hz_{rate_hz} {
  const io::Ffmpeg probe{io::Ffmpeg::Pipe::output, {"-version"}};
  if (file_.has_parent_path()) io::create_folder(file_.parent_path());
  std::signal(SIGPIPE, SIG_IGN);  // if ffmpeg ends early, write() says so
}

Video::~Video() {
  if (!ffmpeg_) return;
  ffmpeg_.reset();
  std::error_code ignored;
  std::filesystem::remove(unfinished_, ignored);
}

void Video::add(const io::RgbImage& picture) {
  if (!ffmpeg_) {
    ffmpeg_.emplace(io::Ffmpeg::Pipe::input,
                    std::vector<std::string>{"-loglevel",
                                             "error",
                                             "-y",
                                             "-f",
                                             "rawvideo",
                                             "-pix_fmt",
                                             "rgb24",
                                             "-video_size",
                                             fmt::format("{}x{}", picture.width, picture.height),
                                             "-framerate",
                                             fmt::format("{:.6g}", rate_hz_),
                                             "-i",
                                             "-",
                                             "-vf",
                                             "crop=trunc(iw/2)*2:trunc(ih/2)*2",
                                             "-c:v",
                                             "libx264",
                                             "-pix_fmt",
                                             "yuv420p",
                                             "-crf",
                                             "18",
                                             "-movflags",
                                             "+faststart",
                                             unfinished_.string()});
  }
  const auto* const bytes{reinterpret_cast<const char*>(picture.pixels.data())};
  if (ffmpeg_->write({bytes, picture.pixels.size()})) return;
  throw DeviceError{fmt::format("{}: ffmpeg has stopped early; its message stands above.", file_.string())};
}

void Video::finish() {
  if (!ffmpeg_) return;
  if (!ffmpeg_->finish()) {
    throw DeviceError{fmt::format("{}: ffmpeg could not make it; its message stands above.", file_.string())};
  }
  std::filesystem::rename(unfinished_, file_);
  ffmpeg_.reset();
}

}  // namespace stereogrid::app
