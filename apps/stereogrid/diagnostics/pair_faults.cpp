// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/frame_tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

using Grey = Image<std::uint8_t>;

// Another explanation must match clearly more of the images than the pair as it is.
constexpr double clearly{1.5};
constexpr double clearly_in_time{1.2};  // slow motion changes little from frame to frame
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

/// Left and right exchanged.
Grey mirrored(const Grey& image) {
  Grey result{image};
  for (int v{0}; v < result.height(); ++v) std::reverse(result.row(v), result.row(v) + result.width());
  return result;
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

bool is_clearly_better(double share, double as_it_is, double factor = clearly) {
  return share > match_share_min && share > factor * as_it_is;
}

/// Share of the pair that matches under an explanation, and the explanation; no text: it matches hardly more.
struct Explanation {
  double share{0};
  std::string text{};
};

bool is_raw(const io::Recording* recording) {
  return recording != nullptr && recording->contents().calibration.raw.has_value();
}

Explanation fault_of_time(const TallyContext& context, const StereoFrame& frame) {
  const double as_it_is{io::coarse_match_share(frame.left, frame.right)};
  Explanation best;
  for (std::size_t by{1}; by <= most_late; ++by) {
    const std::size_t index{static_cast<std::size_t>(frame.index) + by};
    const auto other{context.input.source ? loaded(*context.input.source, index) : context.frame_at(index)};
    if (!other) continue;
    const bool is_left_still{other->left == frame.left};
    if (is_left_still != (other->right == frame.right)) {
      return {1, fmt::format(
                     "the {} image of {} is the same as that of {}: that camera has stopped, or its images are copies.",
                     is_left_still ? "left" : "right", other->name, frame.name)};
    }
    const double late{io::coarse_match_share(frame.left, other->right)};
    const double early{io::coarse_match_share(other->left, frame.right)};
    if (std::max(late, early) <= best.share) continue;
    best = {
        std::max(late, early),
        fmt::format("the {} images are {} late: this {} image belongs to the {} image of {}. Pair images of the same "
                    "instant.",
                    late > early ? "right" : "left", by == 1 ? "a frame" : fmt::format("{} frames", by),
                    late > early ? "left" : "right", late > early ? "right" : "left", other->name)};
  }
  return is_clearly_better(best.share, as_it_is, clearly_in_time) ? best : Explanation{};
}

Explanation shifted_rows(const StereoFrame& frame, double as_it_is) {
  double best{0};
  int best_rows{0};
  for (const int rows :
       {-48, -32, -24, -16, -12, -10, -8, -7, -6, -5, -4, -3, -2, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 24, 32, 48}) {
    const double share{io::coarse_match_share(frame.left, moved(frame.right, rows))};
    if (share > best) {
      best = share;
      best_rows = rows;
    }
  }
  if (!is_clearly_better(best, as_it_is)) return {};
  return {best,
          fmt::format("vertical misalignment: the right image lies about {} rows too {}. The pair is not rectified, "
                      "or not with its own calibration.",
                      std::abs(best_rows), best_rows < 0 ? "low" : "high")};
}

/// Image turned by 90° clockwise.
Grey turned_by_quarter(const Grey& image) {
  Grey result{image.height(), image.width()};
  for (int v{0}; v < image.height(); ++v) {
    for (int u{0}; u < image.width(); ++u) result(image.height() - 1 - v, u) = image(u, v);
  }
  return result;
}

/// Both images turned by 90°, as of a camera on its side. A calibration of raw images is refused there; with another
/// fault of it, disparities match as shifted rows of turned images.
Explanation turned_images(const StereoFrame& frame, const TallyContext& context, double as_it_is) {
  if (is_raw(context.input.recording)) return {};
  const Grey left{turned_by_quarter(frame.left)};
  const Grey right{turned_by_quarter(frame.right)};
  const double clockwise{io::coarse_match_share(left, right)};  // turned the other way, left and right are exchanged
  const double counterclockwise{io::coarse_match_share(right, left)};
  const double best{std::max(clockwise, counterclockwise)};
  if (!is_clearly_better(best, as_it_is)) return {};
  return {best,
          fmt::format("the images are turned by 90°: they match when both are turned {}. Turn them before, and give "
                      "the calibration of the turned images.",
                      clockwise > counterclockwise ? "clockwise" : "counterclockwise")};
}

/// One image mirrored.
Explanation mirrored_image(const StereoFrame& frame, double as_it_is) {
  const double of_left{io::coarse_match_share(mirrored(frame.left), frame.right)};
  const double of_right{io::coarse_match_share(frame.left, mirrored(frame.right))};
  const double best{std::max(of_left, of_right)};
  if (!is_clearly_better(best, as_it_is)) return {};
  return {best, fmt::format("the {} image is mirrored: they match when it is mirrored back. Switch that off in the "
                            "camera or its driver.",
                            of_left > of_right ? "left" : "right")};
}

/// Tests whether the images of a raw pair match without rectification.
std::string fault_of_rectification(const io::Recording* recording, std::size_t index, double as_it_is) {
  if (!is_raw(recording)) return {};
  const StereoFrame frame{recording->load_unrectified(index)};
  const double share{io::coarse_match_share(frame.left, frame.right)};
  if (!is_clearly_better(share, as_it_is)) return {};
  return "the calibration is of raw images, but these are rectified already. Give the calibration of the rectified "
         "pair: of ROS's files with 'images: rectified' in a calibration.yaml that names them.";
}

/// Tests whether the scene is nearer than the search range.
std::string fault_of_range(const StereoFrame& frame, const TallyContext& context) {
  const Rig& rig{context.source_rig};
  const Pipeline pipeline{context.config, rig};
  const int disparities{pipeline.config().matching.disparities};
  const auto nearest_px{io::near_disparity_px(frame, disparities)};
  if (!nearest_px) return {};
  const double focal_baseline{rig.focal_px * rig.baseline_m};
  return fmt::format(
      "the scene is nearer than the search range: points match up to {:.0f} px, but matching.disparities is {} ({:.2f} "
      "m). Set matching.disparities to {:.0f}.",
      *nearest_px, disparities, focal_baseline / (disparities - 1), 32 * std::ceil((*nearest_px + 1) / 32));
}

}  // namespace

bool is_without_texture(const StereoFrame& frame) {
  return is_without_texture(frame.left) || is_without_texture(frame.right);
}

namespace {

/// Ground of a frame alone, which is processed up to `times`, since estimated extrinsics may need three frames; none:
/// it does not show the road.
std::optional<Ground> ground_of(const StereoFrame& frame, const TallyContext& context, const Rig& rig, int times = 1) {
  constexpr std::int64_t step_ns{100'000'000};
  Pipeline pipeline{context.config, rig, {.stages = false, .extrinsics_given = context.input.extrinsics_given}};
  StereoFrame still{frame};
  for (int i{0}; i < times; ++i) {
    const FrameResult& result{pipeline.process(still)};
    if (shows_road(io::summary_of(still, result))) return result.ground;
    still.stamp_ns += step_ns;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> fault_if_upside_down(const StereoFrame& frame, const TallyContext& context) {
  if (frame.right.empty() || frame.right.width() != frame.left.width()) return std::nullopt;
  StereoFrame other{frame};
  other.left = turned(frame.left);
  other.right = turned(frame.right);
  Rig below{context.source_rig};
  bool is_found{ground_of(other, context, below).has_value()};  // cameras turned one by one
  if (!is_found) {
    below.cx_px = below.width_px - 1 - below.cx_px;
    below.cy_px = below.height_px - 1 - below.cy_px;
    std::swap(other.left, other.right);
    is_found = ground_of(other, context, below).has_value();
  }
  if (!is_found) return std::nullopt;
  return "the images are upside down: the road is above. Add 'rotate: 180' to calibration.yaml (one with 'from: FILE' "
         "where another tool has written the calibration).";
}

std::optional<std::string> fault_of_residual(const StereoFrame& frame) {
  constexpr double largest_px{0.75};
  const auto residual_px{io::row_residual_px(frame)};
  if (!residual_px || *residual_px <= largest_px) return std::nullopt;
  return fmt::format(
      "vertical misalignment: matched corners of both images lie on rows that differ by {:.1f} px (median). The pair "
      "is not rectified, or not with its own calibration.",
      *residual_px);
}

std::optional<std::string> fault_of_shift(const StereoFrame& frame, const TallyContext& context) {
  const auto problem{io::finding_if_shifted(frame, context.source_rig)};
  if (!problem) return std::nullopt;
  if (const auto other{fault_if_upside_down(frame, context)}) return other;
  if (std::string late{fault_of_time(context, frame).text}; !late.empty()) return late;  // motion shifts the images
  const auto misaligned{fault_of_residual(frame)};
  return misaligned ? misaligned : problem;
}

std::string fault_of_scale(const StereoFrame& frame, const TallyContext& context) {
  if (frame.disparity.empty()) return {};
  const bool is_depth{context.input.recording != nullptr && context.input.recording->contents().has_depth};
  struct Unit {
    double factor;  ///< from the disparities as they were read to those in px
    const char* name;
    bool is_reciprocal{false};  ///< the factor is that of the reciprocals
  };
  const double focal_baseline{context.source_rig.focal_px * context.source_rig.baseline_m};
  // SGBM's sixteenths; PNG of other factors than KITTI's 256
  const std::array of_disparities{
      Unit{focal_baseline, "depths in m. Put them into depth/, or give --depth DIR", true},
      Unit{1.0 / 16, "16 times too large, as OpenCV's fixed-point result. Divide them by 16"},
      Unit{4, "4 times too small, as of a PNG with 64 instead of 256. Multiply them by 4"},
      Unit{2.56,
           "2.56 times too small, as of a PNG with 100 instead of 256. Multiply them "
           "by 2.56"},
      Unit{16, "16 times too small, as of a PNG with 16 instead of 256. Multiply them by 16"},
      Unit{256, "256 times too small, as of a PNG in whole px. Multiply them by 256"}};
  const std::array of_depths{
      Unit{focal_baseline, "disparities in px. Put them into disparity/, or give --disparities DIR", true},
      Unit{focal_baseline * focal_baseline, "inverse depths in 1/m. Take their reciprocals", true},
      Unit{10, "10 times too large, as in units of 0.1 mm. Give --depth-scale 10000"},
      Unit{4, "4 times too large, as in units of 0.25 mm. Give --depth-scale 4000"},
      Unit{5, "5 times too large, as TUM's. Give --depth-scale 5000"},
      Unit{1000,
           "1000 times too large, as floats in millimetres instead of metres. Divide them by "
           "1000"},
      Unit{0.256, "3.9 times too small, as KITTI's. Give --depth-scale 256"},
      Unit{0.001, "1000 times too small, as floats in kilometres. Multiply them by 1000"}};
  constexpr int times{4};
  if (ground_of(frame, context, context.source_rig, times)) return {};  // nothing is wrong with the scale
  std::vector<std::pair<double, std::string>> possible;                 // by distance from a usual height
  for (const Unit& unit : is_depth ? std::span<const Unit>{of_depths} : std::span<const Unit>{of_disparities}) {
    StereoFrame scaled{frame};
    for (float& d : scaled.disparity) {
      if (unit.is_reciprocal && d > 0) d = 1 / d;
      d *= static_cast<float>(unit.factor);
    }
    const auto ground{ground_of(scaled, context, context.source_rig, times)};
    if (!ground) continue;
    constexpr double usual_height_m{1};
    possible.emplace_back(
        std::abs(std::log(ground->height_m / usual_height_m)),
        fmt::format("{}: then the ground lies {:.2f} m below the camera", unit.name, ground->height_m));
  }
  if (possible.empty()) return {};
  std::ranges::sort(possible);
  std::string text{fmt::format("there is no ground as the {} are. They seem to be {}",
                               is_depth ? "depths" : "disparities", possible.front().second)};
  for (std::size_t i{1}; i < possible.size(); ++i) text += ". Or they are " + possible[i].second;
  return text + ".";
}

std::vector<std::string> faults_of_frame(const StereoFrame& frame, const TallyContext& context) {
  std::vector<std::string> texts;
  for (const auto& fault : {fault_of_shift(frame, context), fault_of_distances(frame, context)}) {
    if (fault) texts.push_back(*fault);
  }
  return texts;
}

std::optional<StereoFrame> loaded(const FrameSource& source, std::size_t index) {
  if (index >= source.size()) return std::nullopt;
  try {
    return source.load(index);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

PairFault fault_of_pair(const TallyContext& context, const StereoFrame& frame) {
  if (frame.right.empty()) return {};
  if (frame.left == frame.right) return {"left and right are the same image: give the right camera's images."};
  if (is_without_texture(frame)) {
    return {"an image is black or without texture: is a lens covered, or the exposure far off?"};
  }
  if (const auto fault{fault_if_upside_down(frame, context)}) return {*fault};
  if (const auto problem{io::finding_if_swapped(frame)}) return {*problem, true};
  const double as_it_is{io::coarse_match_share(frame.left, frame.right)};
  const Explanation shifted{shifted_rows(frame, as_it_is)};  // motion shifts rows, too
  if (const Explanation late{fault_of_time(context, frame)}; late.share > shifted.share) return {late.text};
  if (io::negative_disparity_px(frame)) {
    return {fault_of_residual(frame).value_or(
        "the right image is shifted: its farthest points have negative disparities.")};
  }
  std::string fault{fault_of_rectification(context.input.recording, static_cast<std::size_t>(frame.index), as_it_is)};
  if (fault.empty()) {  // the best one: shifted rows are shifted columns of turned images
    fault = std::ranges::max({shifted, turned_images(frame, context, as_it_is), mirrored_image(frame, as_it_is)}, {},
                             &Explanation::share)
                .text;
  }
  if (fault.empty()) fault = fault_of_range(frame, context);
  if (fault.empty()) fault = fault_of_residual(frame).value_or("");
  return {fault};
}

}  // namespace stereogrid::app
