// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/recording_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "files/file_access.hpp"
#include "stereogrid/error.hpp"
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

}  // namespace stereogrid::io
