// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/calibration_forms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "input/calibration/raw_pair.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

constexpr double alike_px{0.01};

/// Number of coefficients of ROS's models.
struct DistortionModel {
  std::string_view name;
  LensModel lens;
  std::vector<std::size_t> counts;
};

/// sensor_msgs/distortion_models.hpp; a rational model may carry OpenCV's further numbers.
const std::vector<DistortionModel>& models() {
  static const std::vector<DistortionModel> all{{"plumb_bob", LensModel::perspective, {4, 5}},
                                                {"rational_polynomial", LensModel::perspective, {8, 12, 14}},
                                                {"equidistant", LensModel::fisheye, {4}},
                                                {"fisheye", LensModel::fisheye, {4}}};
  return all;
}

void take_distortion(CameraModel& model, const RosSide& side, const RosTerms& terms) {
  const std::string name{side.camera.distortion_model.empty() ? "plumb_bob" : side.camera.distortion_model};
  const auto known{std::ranges::find(models(), name, &DistortionModel::name)};
  if (known == models().end()) {
    side.origin.fail("has a 'distortion_model' that is none of plumb_bob, rational_polynomial and equidistant.",
                     std::string{"Calibrate with one of these."} + terms.if_rectified);
  }
  model.lens = known->lens;
  model.distortion = side.camera.d;
  if (model.distortion.empty()) {
    side.origin.fail(fmt::format("has no numbers in '{}': raw images cannot be rectified with it.", terms.d),
                     std::string{"Write five zeros where there is no distortion."} + terms.if_rectified);
  }
  if (std::ranges::count(known->counts, model.distortion.size()) == 0) {
    side.origin.fail(fmt::format("has {} distortion numbers, as {} does not.", model.distortion.size(), name),
                     "plumb_bob has 5, rational_polynomial 8, equidistant 4.");
  }
}

CameraModel model_of(const RosSide& side, const RosTerms& terms) {
  const auto& k{side.camera.k};
  if (k[0] == 0) {
    side.origin.fail(fmt::format("is of a camera that is not calibrated: the focal length in '{}' is 0.", terms.k),
                     calibrate_together);
  }
  CameraModel model{camera_of({k.begin(), k.end()}, side.origin, terms.k)};
  take_distortion(model, side, terms);
  check_camera(model, side.origin);
  return model;
}

void check_projection(const RosSide& side, const RosTerms& terms) {
  const auto& p{side.camera.p};
  if (p[0] == 0) {
    side.origin.fail(fmt::format("is of a camera that is not calibrated: the focal length in '{}' is 0.", terms.p),
                     calibrate_together);
  }
  if (p[1] != 0 || p[4] != 0 || p[8] != 0 || p[9] != 0 || p[10] != 1 || p[11] != 0) {
    side.origin.fail(fmt::format("'{}' is none of a rectified pair.", terms.p),
                     "It is fx 0 cx Tx, 0 fy cy Ty, 0 0 1 0, in pixels.");
  }
  if (p[0] < 1 || std::abs(p[0] - p[5]) > 0.01 * p[0]) {
    side.origin.fail(fmt::format("has focal lengths {:.6g} and {:.6g} px in '{}'.", p[0], p[5], terms.p),
                     "A rectified pair has one, of a pixel at least. " + std::string{calibrate_together});
  }
}

void check_size(const RosSide& left, const RosSide& right) {
  const RosCamera& a{left.camera};
  const RosCamera& b{right.camera};
  if (a.width_px == b.width_px && a.height_px == b.height_px) return;
  right.origin.fail(fmt::format("is for images of {}×{} px, but {} for {}×{}.", b.width_px, b.height_px,
                                left.origin.file(), a.width_px, a.height_px),
                    "Both cameras' images have the same size. " + std::string{calibrate_together});
}

void check_pair(const RosSide& left, const RosSide& right, const RosTerms& terms) {
  const auto& p{left.camera.p};
  const auto& q{right.camera.p};
  const auto differ{[&](std::size_t i) { return std::abs(p[i] - q[i]) > alike_px; }};
  if (differ(5) || differ(6)) {
    right.origin.fail(fmt::format("rows differ: '{}' has fy {:.6g} and cy {:.6g}, that of {} {:.6g} and {:.6g}.",
                                  terms.p, q[5], q[6], left.origin.file(), p[5], p[6]),
                      "So the cameras were calibrated one by one. " + std::string{calibrate_together});
  }
  if (differ(7)) {
    right.origin.fail(fmt::format("puts one camera above the other: Ty in '{}' is not 0.", terms.p),
                      "Cameras have to stand side by side.");
  }
  if (p[3] < q[3] && p[3] < 0) {
    left.origin.fail(fmt::format("is the right camera's: Tx in its '{}' is {:.6g}.", terms.p, p[3]),
                     "Exchange left and right: the names of the two files, or of the topics.");
  }
  if (p[3] < q[3]) {
    right.origin.fail(fmt::format("has a positive Tx of {:.6g} in '{}': a negative baseline.", q[3] - p[3], terms.p),
                      "Left and right are swapped: Tx of the right camera is −fx·baseline. Exchange the cameras and "
                      "calibrate again, or correct the sign.");
  }
}

/// Position of the left camera to the right of the right one, m: negative.
double shift_of(const RosSide& left, const RosSide& right, const RosTerms& terms, bool has_given_baseline) {
  const auto& p{left.camera.p};
  const auto& q{right.camera.p};
  const double shift_m{q[3] / q[0] - p[3] / p[0]};
  if (shift_m != 0) return shift_m;
  if (has_given_baseline) return -1;  // any length
  right.origin.fail(fmt::format("has the same Tx in '{}' as the left camera: the baseline is zero.", terms.p),
                    "Tx of the right camera is −fx·baseline. " + std::string{calibrate_together} + terms.if_measured);
}

void take_rectified(Calibration& calibration, const RosSide& left, const RosSide& right, const RosTerms& terms,
                    double shift_m) {
  const auto& p{left.camera.p};
  const auto& q{right.camera.p};
  if (std::abs(p[0] - q[0]) > alike_px) {
    right.origin.fail(fmt::format("has another focal length in '{}' ({:.6g} px) than the left camera ({:.6g} px).",
                                  terms.p, q[0], p[0]),
                      "Rectify both cameras to one focal length, or give the raw images.");
  }
  Rig rig;
  rig.focal_px = p[0];
  rig.cx_px = p[2];
  rig.cy_px = p[6];
  rig.baseline_m = -shift_m;
  take_row_aligned(calibration, rig, q[2]);
}

/// Points of both cameras before rectification: R of either takes them to the rectified one, x_rectified = R x.
RawPair raw_pair(const RosSide& left, const RosSide& right, const RosTerms& terms, double shift_m) {
  const auto turn_of{[&](const RosSide& side) {
    return rotation_of({side.camera.r.begin(), side.camera.r.end()}, side.origin, terms.r);
  }};
  const cv::Matx33d right_turn{turn_of(right)};
  RawPair raw;
  raw.left = model_of(left, terms);
  raw.right = model_of(right, terms);
  set_transform(raw, right_turn.t() * turn_of(left), right_turn.t() * cv::Vec3d{shift_m, 0, 0});
  return raw;
}

/// Files are looked through as they are read.
void check_numbers(const RosSide& side) {
  constexpr double largest{1e9};
  const auto is_one = [](double number) { return std::abs(number) <= largest; };  // not NaN
  const RosCamera& camera{side.camera};
  const auto are_some = [&](const auto& numbers) { return std::ranges::all_of(numbers, is_one); };
  if (!are_some(camera.k) || !are_some(camera.d) || !are_some(camera.r) || !are_some(camera.p)) {
    side.origin.fail("has numbers that are none, or above 1e9.", calibrate_together);
  }
}

}  // namespace

Calibration ros_pair(const RosSide& left, const RosSide& right, const RosTerms& terms, bool are_rectified,
                     bool has_given_baseline) {
  check_size(left, right);
  check_projection(left, terms);
  check_projection(right, terms);
  check_pair(left, right, terms);
  const double shift_m{shift_of(left, right, terms, has_given_baseline)};
  Calibration calibration;
  calibration.rig.width_px = left.camera.width_px;
  calibration.rig.height_px = left.camera.height_px;
  if (are_rectified) {
    take_rectified(calibration, left, right, terms, shift_m);
  } else {
    calibration.raw = raw_pair(left, right, terms, shift_m);
  }
  return calibration;
}

Calibration ros_calibration(const RosCamera& left, const RosCamera& right, bool are_rectified) {
  constexpr RosTerms of_messages{"K", "D", "R", "P", "", ""};
  const char* const other_way{"Or give a calibration.yaml with --calibration FILE (docs/input.md)."};
  const Origin of_left{printable(left.name), "", other_way};
  const Origin of_right{printable(right.name), "", other_way};
  check_numbers({left, of_left});
  check_numbers({right, of_right});
  Calibration calibration{ros_pair({left, of_left}, {right, of_right}, of_messages, are_rectified, false)};
  if (calibration.raw) take_rig_of_raw(calibration, of_left, {});
  if (const auto found{problems(calibration.rig)}; !found.empty()) of_right.fail(found.front(), calibrate_together);
  return calibration;
}

}  // namespace stereogrid::io
