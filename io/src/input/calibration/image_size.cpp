// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/raw_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

namespace stereogrid::io {
namespace {

// Limits of the principal point's distance from the middle, as a share of the image's size. Real cameras and rectified
// pairs stay below 0.04 along either axis (KITTI, EuRoC, Karlsruhe, Zagreb, ZED).
constexpr double odd_offset{0.05};
constexpr double wrong_offset{0.3};
// Mean over both axes where the two agree: scaling moves the point by the same share along both, cropping does not.
constexpr double odd_scale_offset{0.04};
constexpr double wrong_scale_offset{0.08};
constexpr double scale_agreement{0.08};

enum class Plausibility { fine, odd, wrong };

/// Principal point relative to an image's size; 0.5 is the middle.
struct Place {
  double u_px;
  double v_px;
  double u;
  double v;

  /// The same factor takes both axes to images whose middle it is.
  [[nodiscard]] bool is_of_scaled_images() const {
    return u > 0 && v > 0 && (u - 0.5) * (v - 0.5) > 0 && std::abs(u / v - 1) < scale_agreement;
  }
  [[nodiscard]] bool is_outside() const { return !(u >= 0 && u <= 1 && v >= 0 && v <= 1); }
};

Place place_of(double u_px, double v_px, const Rig& size) {
  return {u_px, v_px, (u_px + 0.5) / size.width_px, (v_px + 0.5) / size.height_px};
}

Plausibility plausibility_of(const Place& place) {
  const double off_u{std::abs(place.u - 0.5)};
  const double off_v{std::abs(place.v - 0.5)};
  const double scale_offset{place.is_of_scaled_images() ? (off_u + off_v) / 2 : 0};
  if (std::max(off_u, off_v) >= wrong_offset || scale_offset >= wrong_scale_offset) return Plausibility::wrong;
  return std::max(off_u, off_v) >= odd_offset || scale_offset >= odd_scale_offset ? Plausibility::odd
                                                                                  : Plausibility::fine;
}

bool is_exact_ratio(const Rig& from, int width_px, int height_px) {
  constexpr int largest{20};
  constexpr int largest_rounded{12};  // maximum of ratios with fractions of a pixel, which are rounded
  const auto remainder = [](std::int64_t from_px, std::int64_t to_px, int times, int by) {
    return std::abs(to_px * by - from_px * times);
  };
  for (int by{1}; by <= largest; ++by) {
    for (int times{1}; times <= largest; ++times) {
      const std::int64_t rest{
          std::max(remainder(from.width_px, width_px, times, by), remainder(from.height_px, height_px, times, by))};
      if (rest == 0 || (rest < by && std::max(times, by) <= largest_rounded)) return true;
    }
  }
  return false;
}

std::string size_key(int width_px, int height_px) {
  return fmt::format("'image: {{width_px: {}, height_px: {}}}'", width_px, height_px);
}

/// Plausibility of the principal point's place.
std::string finding_of(const Place& place, const char* camera, const Rig& size) {
  const std::string cause{
      place.is_of_scaled_images()
          ? fmt::format("the calibration seems to be of images of about {:.0f}×{:.0f} px, these are scaled by {:.3g}",
                        2 * place.u * size.width_px, 2 * place.v * size.height_px, 1 / (place.u + place.v))
          : "the images seem to be cropped, or the calibration to be of other images"};
  return fmt::format(
      "the {}principal point ({:.6g}, {:.6g}) px lies {} images of {}×{} px, at {:.0f} % of the width and {:.0f} % of "
      "the "
      "height: {}.",
      camera, place.u_px, place.v_px, place.is_outside() ? "outside" : "off the middle of", size.width_px,
      size.height_px, 100 * place.u, 100 * place.v, cause);
}

/// The estimated size, where it is one from which the calibration would be scaled.
std::string likely_size(const Place& place, const Rig& size) {
  Rig likely;
  likely.width_px = static_cast<int>(std::clamp(std::round(2 * place.u * size.width_px), 1.0, 1e6));
  likely.height_px = static_cast<int>(std::clamp(std::round(2 * place.v * size.height_px), 1.0, 1e6));
  if (is_exact_ratio(likely, size.width_px, size.height_px)) return size_key(likely.width_px, likely.height_px);
  return "'image: {width_px: …, height_px: …}'";
}

std::string remedy_of(const Place& place, const Rig& size, bool is_own_form) {
  const char* const where{is_own_form ? "" : " to a calibration.yaml that names this file ('from: FILE')"};
  const bool is_scaled{place.is_of_scaled_images()};
  std::string remedy{is_scaled
                         ? fmt::format("Add the size of the calibrated images{}, {}: the calibration is scaled then.",
                                       where, likely_size(place, size))
                         : "Use the calibration of these images."};
  if (place.is_outside()) return remedy;
  return remedy + fmt::format(" If the principal point is right, add {}{}.", size_key(size.width_px, size.height_px),
                              is_scaled ? "" : where);
}

void add_once(std::vector<std::string>& to, std::string text) {
  if (std::ranges::find(to, text) == to.end()) to.push_back(std::move(text));
}

void check_centre(Calibration& calibration, const Place& place, const char* camera, const Origin& origin,
                  bool has_size) {
  const Rig& size{calibration.rig};
  const Plausibility plausibility{plausibility_of(place)};
  const std::string remedy{remedy_of(place, size, calibration.kind == "calibration.yaml")};
  if (place.is_outside() || (plausibility == Plausibility::wrong && !has_size)) {
    origin.fail(finding_of(place, camera, size), remedy);
  }
  // A stated size is accepted if a crop or an unusual lens may explain the principal point.
  if (has_size && plausibility == Plausibility::wrong) {
    add_once(calibration.warnings, finding_of(place, camera, size) +
                                       " Check that the focal length and the principal "
                                       "point belong to images of this size.");
  }
  if (!has_size && plausibility == Plausibility::odd) {
    add_once(calibration.warnings, finding_of(place, camera, size) + " " + remedy);
  }
}

/// Pixel centres are at integers: the image begins half a pixel before the first one.
void scale(double& centre_px, double factor) {
  centre_px = (centre_px + 0.5) * factor - 0.5;
}

void scale(Calibration& calibration, double along_u, double along_v) {
  if (!calibration.raw) {
    calibration.rig.focal_px *= along_u;
    scale(calibration.rig.cx_px, along_u);
    scale(calibration.rig.cy_px, along_v);
    return;
  }
  for (CameraModel* camera : {&calibration.raw->left, &calibration.raw->right}) {
    camera->focal_u_px *= along_u;
    camera->focal_v_px *= along_v;
    scale(camera->cx_px, along_u);
    scale(camera->cy_px, along_v);
  }
}

void scale_to(Calibration& calibration, const Origin& origin, const CalibrationRequest& request) {
  const Rig& from{calibration.rig};
  const std::string sizes{fmt::format("is for images of {}×{} px, but the images have {}×{}", from.width_px,
                                      from.height_px, request.width_px, request.height_px)};
  if (!is_exact_ratio(from, request.width_px, request.height_px)) {
    origin.fail(sizes + ", which is not an exact multiple or fraction of that.",
                "Use the calibration of these images (for KITTI raw: of the synced and rectified drive). Where they "
                "were cropped, correct the principal point and the size.");
  }
  const double along_u{static_cast<double>(request.width_px) / from.width_px};
  calibration.notes.push_back(fmt::format(
      "size: the calibration {}: scaled by {:.4g}. If the images were cropped to that size, correct the principal "
      "point and the size instead",
      sizes, along_u));
  scale(calibration, along_u, static_cast<double>(request.height_px) / from.height_px);
}

}  // namespace

void fit_size(Calibration& calibration, const Origin& origin, const CalibrationRequest& request) {
  Rig& rig{calibration.rig};
  if (request.width_px == 0 || request.height_px == 0) return;
  const bool has_size{rig.width_px != 0 && rig.height_px != 0};
  if (has_size && (rig.width_px != request.width_px || rig.height_px != request.height_px)) {
    scale_to(calibration, origin, request);
  }
  rig.width_px = request.width_px;
  rig.height_px = request.height_px;
  const bool is_stated{has_size || request.has_stated_size};
  if (calibration.raw) {
    const auto check = [&](const CameraModel& camera, const char* name) {
      check_centre(calibration, place_of(camera.cx_px, camera.cy_px, rig), name, origin, is_stated);
    };
    const CameraModel& left{calibration.raw->left};
    const CameraModel& right{calibration.raw->right};
    const bool is_left_enough{is_row_aligned(*calibration.raw)};  // cx of the right one includes the disparity offset
    const bool are_equal{is_left_enough || (left.cx_px == right.cx_px && left.cy_px == right.cy_px)};
    check(left, are_equal ? "" : "left camera's ");
    if (!are_equal) check(right, "right camera's ");
  } else {
    check_centre(calibration, place_of(rig.cx_px, rig.cy_px, rig), "", origin, is_stated);
  }
}

void fit_to_images(Calibration& calibration, const std::string& name, int width_px, int height_px) {
  const Origin origin{name};
  const CalibrationRequest request{width_px, height_px};
  const bool is_other{calibration.rig.width_px != width_px || calibration.rig.height_px != height_px};
  if (calibration.raw && is_other && width_px != 0) return take_rig_of_raw(calibration, origin, request);
  fit_size(calibration, origin, request);
}

}  // namespace stereogrid::io
