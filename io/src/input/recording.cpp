// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/recording.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "files/unavailable.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/disparity_file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

template <class T>
std::string size_of(const Image<T>& image) {
  return fmt::format("{}×{}", image.width(), image.height());
}

void need(const std::filesystem::path& path, bool exists, const char* side) {
  if (exists) return;
  throw InputError{printable_path(path), fmt::format("the {} image of this frame is missing.", side),
                   "Add it; the frame is left out meanwhile."};
}

template <class T>
void need_equal_size(const Image<std::uint8_t>& left, const std::filesystem::path& left_file, const Image<T>& other,
                     const std::filesystem::path& other_file) {
  if (left.width() == other.width() && left.height() == other.height()) return;
  throw InputError{printable_path(left_file),
                   fmt::format("has {} px, but {} has {}.", size_of(left), printable_path(other_file), size_of(other)),
                   "The two images of a frame have the same size."};
}

}  // namespace

ImageStore::~ImageStore() = default;

Recording::Recording(RecordingContents contents, std::unique_ptr<ImageStore> images)
    : contents_{std::move(contents)}, images_{std::move(images)} {
  if (contents_.calibration.raw) rectifier_.emplace(*contents_.calibration.raw, rig().width_px, rig().height_px);
}

StereoFrame Recording::load_unrectified(std::size_t index) const {
  const RecordedFrame& source{contents_.frames.at(index)};
  StereoFrame frame;
  frame.name = source.name;
  frame.index = static_cast<std::int64_t>(index);
  frame.stamp_ns = source.stamp_ns;
  frame.world_from_vehicle = source.world_from_vehicle;
  if (images_) {
    ImagePair pair{images_->load(index)};
    frame.left = std::move(pair.left);
    frame.right = std::move(pair.right);
    if (frame.left.width() != frame.right.width() || frame.left.height() != frame.right.height()) {
      throw InputError{printable_path(source.left),
                       fmt::format("the left image of frame {} has {} px, but the right one has {}.", source.name,
                                   size_of(frame.left), size_of(frame.right)),
                       "The two images of a frame have the same size."};
    }
  } else {
    need(source.left, source.left_exists, "left");
    read_listed([&] {
      frame.left = read_grey(source.left, contents_.sample_bits);
      load_second_image(source, frame);
    });
  }
  return frame;
}

std::vector<ScanPoint> Recording::load_scan(std::size_t index) const {
  return read_listed([&] { return read_scan(contents_.frames.at(index).scan); });
}

StereoFrame Recording::load(std::size_t index) const {
  StereoFrame frame{load_unrectified(index)};
  if (frame.left.width() != rig().width_px || frame.left.height() != rig().height_px) {
    throw InputError{printable_path(contents_.frames[index].left),
                     fmt::format("has {} px, but the calibration is for {}×{}.", size_of(frame.left), rig().width_px,
                                 rig().height_px),
                     "All frames of a recording have the same size."};
  }
  if (rectifier_) {
    frame.left = rectifier_->left(frame.left);
    if (!frame.right.empty()) frame.right = rectifier_->right(frame.right);
  }
  return frame;
}

void Recording::load_second_image(const RecordedFrame& source, StereoFrame& frame) const {
  if (gives_disparities()) {
    need(source.disparity, source.right_exists, "disparity");
    frame.disparity = read_disparity(source.disparity);
    need_equal_size(frame.left, source.left, frame.disparity, source.disparity);
  } else {
    need(source.right, source.right_exists, "right");
    frame.right = read_grey(source.right, contents_.sample_bits);
    need_equal_size(frame.left, source.left, frame.right, source.right);
  }
}

bool Recording::has_scans() const {
  return std::ranges::any_of(contents_.frames, [](const RecordedFrame& frame) { return !frame.scan.empty(); });
}

}  // namespace stereogrid::io
