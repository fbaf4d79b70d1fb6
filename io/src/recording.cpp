// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/recording.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::io {
namespace {

std::string size_of(const Image<std::uint8_t>& image) {
  return fmt::format("{}×{}", image.width(), image.height());
}

Image<std::uint8_t> read_side(const std::filesystem::path& path, bool exists, const char* side, int bits) {
  if (!exists) {
    throw InputError{path.string(), fmt::format("the {} image of this frame is missing.", side),
                     "Add it; the frame is left out meanwhile."};
  }
  return read_grey(path, bits);
}

}  // namespace

Recording::Recording(RecordingContents contents) : contents_{std::move(contents)} {
  if (contents_.calibration.raw) rectifier_.emplace(*contents_.calibration.raw, rig().width_px, rig().height_px);
}

StereoFrame Recording::load(std::size_t index) const {
  const RecordedFrame& source{contents_.frames.at(index)};
  StereoFrame frame;
  frame.name = source.name;
  frame.index = static_cast<std::int64_t>(index);
  frame.stamp_ns = source.stamp_ns;
  frame.world_from_vehicle = source.world_from_vehicle;
  frame.left = read_side(source.left, source.left_exists, "left", contents_.sample_bits);
  frame.right = read_side(source.right, source.right_exists, "right", contents_.sample_bits);
  if (frame.left.width() != frame.right.width() || frame.left.height() != frame.right.height()) {
    throw InputError{
        source.left.string(),
        fmt::format("has {} px, but {} has {}.", size_of(frame.left), source.right.string(), size_of(frame.right)),
        "The two images of a pair have the same size."};
  }
  if (frame.left.width() != rig().width_px || frame.left.height() != rig().height_px) {
    throw InputError{source.left.string(),
                     fmt::format("and {} have {} px, but the calibration is for {}×{}.", source.right.string(),
                                 size_of(frame.left), rig().width_px, rig().height_px),
                     "All frames of a recording have the same size."};
  }
  if (rectifier_) {
    frame.left = rectifier_->left(frame.left);
    frame.right = rectifier_->right(frame.right);
  }
  return frame;
}

bool Recording::has_scans() const {
  return std::ranges::any_of(contents_.frames, [](const RecordedFrame& frame) { return !frame.scan.empty(); });
}

}  // namespace stereogrid::io
