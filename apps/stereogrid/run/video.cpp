// SPDX-License-Identifier: Apache-2.0
#include "run/result_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <csignal>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app {

namespace fs = std::filesystem;

std::vector<std::string> encoder_of(const fs::path& file) {
  std::string ending{file.extension().string()};
  std::ranges::transform(ending, ending.begin(), [](unsigned char letter) { return std::tolower(letter); });
  const std::string reduced{"scale='min(960,iw)':-2:flags=area"};
  // a palette per frame, so that ffmpeg needs no memory for the whole film
  const std::string palette{",split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=bayer"};
  if (ending == ".gif") return {"-vf", reduced + palette, "-loop", "0"};
  if (ending == ".webp") return {"-vf", reduced, "-c:v", "libwebp_anim", "-quality", "80", "-loop", "0"};
  return {"-vf",       "crop=trunc(iw/2)*2:trunc(ih/2)*2",
          "-c:v",      "libx264",
          "-pix_fmt",  "yuv420p",
          "-crf",      "18",
          "-movflags", "+faststart"};
}

Video::Video(const fs::path& file, double rate_hz)
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
  fs::remove(unfinished_, ignored);
}

void Video::add(const io::RgbImage& picture) {
  if (!ffmpeg_) {
    std::vector<std::string> arguments{"-loglevel",
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
                                       "-"};
    for (std::string& argument : encoder_of(file_)) arguments.push_back(std::move(argument));
    arguments.push_back(unfinished_.string());
    ffmpeg_.emplace(io::Ffmpeg::Pipe::input, std::move(arguments));
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
  fs::rename(unfinished_, file_);
  ffmpeg_.reset();
}

}  // namespace stereogrid::app
