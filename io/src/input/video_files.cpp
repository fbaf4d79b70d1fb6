// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/recording_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

const std::set<std::string> video_extensions{".avi",  ".mp4",  ".m4v",  ".mov",   ".mkv",  ".webm",
                                             ".mpg",  ".mpeg", ".m2ts", ".wmv",   ".flv",  ".h264",
                                             ".h265", ".hevc", ".y4m",  ".mjpeg", ".mjpg", ".ogv"};

/// The beginning of a container or stream of video, whatever its name.
bool starts_like_video(std::string_view bytes) {
  constexpr std::array beginnings{"\x1a\x45\xdf\xa3"sv,  // Matroska, WebM
                                  "\x00\x00\x01\xba"sv,
                                  "\x00\x00\x01\xb3"sv,                  // MPEG program stream, MPEG-1 and -2
                                  "\x00\x00\x00\x01"sv,                  // H.264, H.265
                                  "\x30\x26\xb2\x75\x8e\x66\xcf\x11"sv,  // ASF, WMV
                                  "FLV\x01"sv,
                                  "YUV4MPEG2"sv,
                                  "OggS"sv};
  if (std::ranges::any_of(beginnings, [&](std::string_view start) { return bytes.starts_with(start); })) return true;
  if (bytes.starts_with("RIFF") && bytes.substr(8).starts_with("AVI ")) return true;
  constexpr std::size_t packet{188};  // packet size of an MPEG transport stream
  if (bytes.size() > packet && bytes[0] == 'G' && bytes[packet] == 'G') return true;
  if (bytes.size() < 12 || bytes.substr(4, 4) != "ftyp") return false;
  const std::string_view brand{bytes.substr(8, 4)};
  return brand != "avif" && brand != "heic" && brand != "mif1";
}

}  // namespace

bool has_video_extension(const fs::path& file) {
  std::string extension{file.extension().string()};
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return video_extensions.contains(extension);
}

bool is_video(const fs::path& file) {
  if (has_video_extension(file)) return is_file(file);
  constexpr std::size_t longest_beginning{200};
  return starts_like_video(first_bytes(file, longest_beginning));
}

void refuse_videos(std::span<const fs::path> files) {
  std::vector<fs::path> videos;
  std::ranges::copy_if(files, std::back_inserter(videos), is_video);
  if (videos.empty()) return;
  const std::string second{videos.size() > 1 ? ", " + printable_path(videos[1]) : ""};
  const std::string others{videos.size() > 2 ? fmt::format(" and {} more", videos.size() - 2) : ""};
  throw InputError{
      printable_path(videos[0]) + second + others,
      "videos whose cameras are not clear (allowed: one of both cameras, or two whose names differ in left "
      "and right only).",
      "Name the video of both cameras, or LEFT RIGHT, with --calibration FILE."};
}

}  // namespace stereogrid::io
