// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/frame_tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

using Grey = Image<std::uint8_t>;

// Another explanation must match clearly more of the images than the pair as it is.
constexpr double clearly{1.5};
constexpr double match_share_min{0.25};

bool is_without_texture(const Grey& image) {
  constexpr int texture_grey{4};
  constexpr int dark_grey{16};
  std::size_t textured{0};
  std::size_t bright{0};
  for (int v{0}; v < image.height(); ++v) {
    for (int u{1}; u + 1 < image.width(); ++u) {
      textured += std::abs(image(u + 1, v) - image(u - 1, v)) >= texture_grey ? 1 : 0;
      bright += image(u, v) >= dark_grey ? 1 : 0;
    }
  }
  return 100 * textured < image.size() || 100 * bright < image.size();
}

Grey turned(const Grey& image) {
  Grey result{image};
  std::reverse(result.begin(), result.end());
  return result;
}

/// Image shifted down by `rows`.
Grey moved(const Grey& image, int rows) {
  Grey result{image.width(), image.height()};
  for (int v{0}; v < image.height(); ++v) {
    const int from{std::clamp(v - rows, 0, image.height() - 1)};
    std::copy_n(image.row(from), image.width(), result.row(v));
  }
  return result;
}

std::optional<StereoFrame> loaded(const FrameSource& source, std::size_t index) {
  if (index >= source.size()) return std::nullopt;
  try {
    return source.load(index);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool is_clearly_better(double share, double as_it_is) {
  return share > match_share_min && share > clearly * as_it_is;
}

std::string fault_of_time(const FrameSource& source, std::size_t index, const StereoFrame& frame, double as_it_is) {
  if (const auto next{loaded(source, index + 1)}) {
    const double late{io::coarse_match_share(frame.left, next->right)};
    const double early{io::coarse_match_share(next->left, frame.right)};
    if (is_clearly_better(std::max(late, early), as_it_is)) {
      return fmt::format(
          "the {} images are a frame late: this {} image belongs to the {} image of the next frame. Pair "
          "images of the same instant.",
          late > early ? "right" : "left", late > early ? "left" : "right", late > early ? "right" : "left");
    }
  }
  return {};
}

std::string fault_of_rows(const StereoFrame& frame, double as_it_is) {
  double best{0};
  int best_rows{0};
  for (const int rows : {-48, -32, -24, -16, -12, -8, -4, 4, 8, 12, 16, 24, 32, 48}) {
    const double share{io::coarse_match_share(frame.left, moved(frame.right, rows))};
    if (share > best) {
      best = share;
      best_rows = rows;
    }
  }
  if (!is_clearly_better(best, as_it_is)) return {};
  return fmt::format(
      "vertical misalignment: the right image lies about {} rows too {}. The pair is not rectified, or not with its "
      "own calibration.",
      std::abs(best_rows), best_rows < 0 ? "low" : "high");
}

/// Tests whether the images of a raw pair match without rectification.
std::string fault_of_rectification(const io::Recording* recording, std::size_t index, double as_it_is) {
  if (recording == nullptr || !recording->contents().calibration.raw) return {};
  const StereoFrame frame{recording->load_unrectified(index)};
  const double share{io::coarse_match_share(frame.left, frame.right)};
  if (!is_clearly_better(share, as_it_is)) return {};
  return "the calibration is of raw images, but these are rectified already. Give the calibration of the rectified "
         "pair: of ROS's files with 'images: rectified' in a calibration.yaml that names them.";
}

}  // namespace

bool is_without_texture(const StereoFrame& frame) {
  return is_without_texture(frame.left) || is_without_texture(frame.right);
}

bool is_upside_down(const StereoFrame& frame, const Config& config, const Rig& rig) {
  if (frame.right.empty()) return false;
  Rig below{rig};
  below.cx_px = rig.width_px - 1 - rig.cx_px;
  below.cy_px = rig.height_px - 1 - rig.cy_px;
  StereoFrame other{frame};
  other.left = turned(frame.right);
  other.right = turned(frame.left);
  Pipeline pipeline{config, below};
  const FrameResult& result{pipeline.process(other)};
  return result.ground.estimated && result.status.empty();
}

PairFault fault_of_pair(const Input& input, std::size_t index, const StereoFrame& frame) {
  if (frame.right.empty()) return {};
  if (frame.left == frame.right) return {"left and right are the same image: give the right camera's images."};
  if (is_without_texture(frame)) {
    return {"an image is black or without texture: is a lens covered, or the exposure far off?"};
  }
  if (const auto problem{io::finding_if_swapped(frame)}) return {*problem, true};
  if (io::negative_disparity_px(frame))
    return {"the right image is shifted: its farthest points have negative disparities."};
  const double as_it_is{io::coarse_match_share(frame.left, frame.right)};
  std::string fault{fault_of_rectification(input.recording, index, as_it_is)};
  if (fault.empty() && input.source) fault = fault_of_time(*input.source, index, frame, as_it_is);
  if (fault.empty()) fault = fault_of_rows(frame, as_it_is);
  return {fault};
}

}  // namespace stereogrid::app
