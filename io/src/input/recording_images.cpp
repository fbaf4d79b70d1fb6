// SPDX-License-Identifier: Apache-2.0
#include "input/recording_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "files/file_access.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

/// Left images that can be read, and their sizes.
struct SizedImage {
  const RecordedFrame* frame;
  Size size;
  int bits;
};

/// The same `count` places from all over any recording; fewer where it is shorter.
std::vector<std::size_t> spread(std::size_t frames, std::size_t count) {
  std::vector<std::size_t> places;
  const std::size_t steps{std::min(count, frames)};
  for (std::size_t i{0}; i < steps; ++i) places.push_back(steps == 1 ? 0 : i * (frames - 1) / (steps - 1));
  return places;
}

/// `count` frames spread over the recording; unreadable ones are left out.
std::vector<SizedImage> some_left_images(const std::vector<RecordedFrame>& frames, std::size_t count,
                                         std::string& first_problem) {
  std::vector<SizedImage> images;
  for (const std::size_t place : spread(frames.size(), count)) {
    const RecordedFrame& frame{frames[place]};
    if (!frame.left_exists) continue;
    try {
      const ScaledImage image{read_listed([&] { return read_scaled(frame.left); })};
      images.push_back({&frame, {image.grey.width(), image.grey.height()}, image.bits});
    } catch (const InputError& error) {
      if (first_problem.empty()) first_problem = error.what();
    }
  }
  return images;
}

bool are_alike(const std::vector<SizedImage>& images) {
  return std::ranges::all_of(images, [&](const SizedImage& image) { return image.size == images.front().size; });
}

Size most_frequent(const std::vector<SizedImage>& images) {
  std::map<Size, int> counts;
  for (const SizedImage& image : images) ++counts[image.size];
  // the first of equal ones
  return std::ranges::max_element(images, {}, [&](const SizedImage& image) { return counts[image.size]; })->size;
}

/// Usual scale of 16-bit images: the most bits of both cameras' images from all over the recording, so that a dark
/// start does not decide.
void find_sample_bits(RecordingContents& contents) {
  constexpr std::size_t looked_at{8};
  std::size_t count{0};
  for (const std::size_t place : spread(contents.frames.size(), looked_at)) {
    const RecordedFrame& frame{contents.frames[place]};
    for (const fs::path& file : {frame.left, frame.right}) {
      try {
        if (file.empty() || !is_there(file)) continue;
        contents.sample_bits = std::max(contents.sample_bits, sample_bits(file));
        ++count;
      } catch (const InputError&) {  // reported where the frame is loaded
      }
    }
  }
  contents.notes.push_back(fmt::format("images: 16-bit files, of which {} bits are used (brightest of {} images)",
                                       contents.sample_bits, count));
}

}  // namespace

Size look_at_images(RecordingContents& contents) {
  constexpr std::size_t few{3};
  constexpr std::size_t many{15};
  std::string first_problem;
  std::vector<SizedImage> images{some_left_images(contents.frames, few, first_problem)};
  if (images.empty() || !are_alike(images)) images = some_left_images(contents.frames, many, first_problem);
  if (images.empty()) images = some_left_images(contents.frames, contents.frames.size(), first_problem);
  if (images.empty() && contents.frames.size() == 1) throw InputError{first_problem};
  if (images.empty()) {
    throw InputError{printable_path(contents.root), "none of the left images can be read.", first_problem};
  }
  const Size size{most_frequent(images)};
  for (const SizedImage& image : images) {
    if (image.size == size) continue;
    contents.warnings.push_back(fmt::format("frame {}: {} has {}×{} px, most others {}×{}: the frame is left out",
                                            image.frame->name, printable_path(image.frame->left), image.size.width_px,
                                            image.size.height_px, size.width_px, size.height_px));
  }
  if (std::ranges::any_of(images, [](const SizedImage& image) { return image.bits > 8; })) find_sample_bits(contents);
  return size;
}

namespace {

Image<std::uint8_t> part_of(const Image<std::uint8_t>& image, int u_px, int v_px, Size size) {
  Image<std::uint8_t> part{size.width_px, size.height_px};
  for (int v{0}; v < size.height_px; ++v) std::copy_n(image.row(v_px + v) + u_px, size.width_px, part.row(v));
  return part;
}

bool can_be_cut(Size whole, ImageLayout layout) {
  return layout == ImageLayout::side_by_side ? whole.width_px % 2 == 0 : whole.height_px % 2 == 0;
}

/// Without error messages about the size or the principal point.
bool fits(const std::filesystem::path& calibration, Size size) {
  try {
    return read_calibration(calibration, size.width_px, size.height_px).warnings.empty();
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

Size size_of_part(Size whole, ImageLayout layout) {
  if (layout == ImageLayout::side_by_side) return {whole.width_px / 2, whole.height_px};
  return layout == ImageLayout::top_bottom ? Size{whole.width_px, whole.height_px / 2} : whole;
}

ImagePair split_pair(const Image<std::uint8_t>& image, int bits, ImageLayout layout, const std::string& name) {
  const Size whole{image.width(), image.height()};
  if (!can_be_cut(whole, layout)) {
    throw InputError{
        name, fmt::format("has {}×{} px, which two images of one size cannot share.", whole.width_px, whole.height_px),
        "Images side by side have an even width, one above the other an even height."};
  }
  const Size size{size_of_part(whole, layout)};
  const int u_px{layout == ImageLayout::side_by_side ? size.width_px : 0};
  const int v_px{layout == ImageLayout::top_bottom ? size.height_px : 0};
  return {part_of(image, 0, 0, size), part_of(image, u_px, v_px, size), bits, bits};
}

ImageLayout find_layout(Size whole, std::optional<ImageLayout> wanted, const std::filesystem::path& calibration,
                        const std::filesystem::path& images) {
  if (wanted) return *wanted;
  const auto is_possible{[&](ImageLayout layout) {
    return can_be_cut(whole, layout) && !calibration.empty() && fits(calibration, size_of_part(whole, layout));
  }};
  const bool beside{is_possible(ImageLayout::side_by_side)};
  const bool above{is_possible(ImageLayout::top_bottom)};
  if (beside != above) return beside ? ImageLayout::side_by_side : ImageLayout::top_bottom;
  if (whole.width_px >= 2 * whole.height_px) return ImageLayout::side_by_side;
  if (whole.width_px <= whole.height_px) return ImageLayout::top_bottom;
  throw InputError{printable_path(images),
                   fmt::format("has images of {}×{} px and no others: left and right image may share them, but it is "
                               "not clear how.",
                               whole.width_px, whole.height_px),
                   "Give --layout side-by-side or --layout top-bottom, or both cameras' images in left/ and right/."};
}

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
