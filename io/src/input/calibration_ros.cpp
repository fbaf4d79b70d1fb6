// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "input/calibration_forms.hpp"
#include "input/raw_pair.hpp"

namespace stereogrid::io {
namespace {

const char* const calibrate_together{
    "Calibrate both cameras together (camera_calibration's cameracalibrator with two cameras), and use its left and "
    "right file."};

/// How many numbers each of ROS's models has.
struct DistortionModel {
  std::string_view name;
  LensModel lens;
  std::vector<std::size_t> counts;
};

/// sensor_msgs/distortion_models.hpp; a rational model may carry OpenCV's further numbers.
const std::vector<DistortionModel>& models() {
  static const std::vector<DistortionModel> all{{"plumb_bob", LensModel::perspective, {4, 5}},
                                                {"rational_polynomial", LensModel::perspective, {8, 12, 14}},
                                                {"equidistant", LensModel::fisheye, {4}}};
  return all;
}

void take_distortion(CameraModel& camera, const YamlGroup& file) {
  const std::string name{file.has("distortion_model") ? file.word("distortion_model") : "plumb_bob"};
  const auto model{std::ranges::find(models(), name, &DistortionModel::name)};
  if (model == models().end()) {
    file.fail("has a 'distortion_model' that is none of plumb_bob, rational_polynomial and equidistant.",
              "Calibrate with one of these; or, where the images are rectified, name this file in a calibration.yaml "
              "with 'images: rectified'.");
  }
  camera.lens = model->lens;
  camera.distortion = file.vector("distortion_coefficients");
  if (camera.distortion.empty()) {
    file.fail("has no numbers in 'distortion_coefficients': raw images cannot be rectified with it.",
              "Write five zeros where there is no distortion; or, where the images are rectified, name this file in a "
              "calibration.yaml with 'images: rectified'.");
  }
  if (std::ranges::count(model->counts, camera.distortion.size()) == 0) {
    file.fail(fmt::format("has {} distortion numbers, as {} does not.", camera.distortion.size(), name),
              "plumb_bob has 5, rational_polynomial 8, equidistant 4.");
  }
}

CameraModel camera_of(const YamlGroup& file) {
  const std::vector<double> k{file.matrix("camera_matrix", 3, 3)};
  if (k[0] == 0) {
    file.fail("is of a camera that is not calibrated: the focal length in 'camera_matrix' is 0.", calibrate_together);
  }
  CameraModel camera{io::camera_of(k, file, "camera_matrix")};
  take_distortion(camera, file);
  check_camera(camera, file);
  return camera;
}

std::vector<double> projection_of(const YamlGroup& file) {
  if (!file.has("projection_matrix")) {
    file.fail("has no 'projection_matrix': it is of one camera that knows of no other.", calibrate_together);
  }
  std::vector<double> p{file.matrix("projection_matrix", 3, 4)};
  if (p[0] == 0) {
    file.fail("is of a camera that is not calibrated: the focal length in 'projection_matrix' is 0.",
              calibrate_together);
  }
  if (p[1] != 0 || p[4] != 0 || p[8] != 0 || p[9] != 0 || p[10] != 1 || p[11] != 0) {
    file.fail("'projection_matrix' is none of a rectified pair.", "It is fx 0 cx Tx, 0 fy cy Ty, 0 0 1 0, in pixels.");
  }
  if (p[0] < 1 || std::abs(p[0] - p[5]) > 0.01 * p[0]) {
    file.fail(fmt::format("has focal lengths {:.6g} and {:.6g} px in 'projection_matrix'.", p[0], p[5]),
              "A rectified pair has one, of a pixel at least. " + std::string{calibrate_together});
  }
  return p;
}

void check_size(const YamlGroup& left, const YamlGroup& right, const Rig& rig) {
  const int width{right.pixels("image_width")};
  const int height{right.pixels("image_height")};
  if (width == rig.width_px && height == rig.height_px) return;
  right.fail(fmt::format("is for images of {}×{} px, but {} for {}×{}.", width, height, left.file(), rig.width_px,
                         rig.height_px),
             "Both cameras' images have the same size. " + std::string{calibrate_together});
}

void check_pair(const YamlGroup& left, const YamlGroup& right, const std::vector<double>& p,
                const std::vector<double>& q) {
  constexpr double alike_px{0.01};
  const auto differ{[&](std::size_t i) { return std::abs(p[i] - q[i]) > alike_px; }};
  if (differ(5) || differ(6)) {
    right.fail(
        fmt::format("rows differ: 'projection_matrix' has fy {:.6g} and cy {:.6g}, that of {} {:.6g} and {:.6g}.", q[5],
                    q[6], left.file(), p[5], p[6]),
        "So the cameras were calibrated one by one. " + std::string{calibrate_together});
  }
  if (std::abs(p[7] - q[7]) > alike_px) {
    right.fail("puts one camera above the other: Ty in 'projection_matrix' is not 0.",
               "Cameras have to stand side by side.");
  }
  if (p[3] < q[3] && p[3] < 0) {
    left.fail(fmt::format("is the right camera's: Tx in its 'projection_matrix' is {:.6g}.", p[3]),
              "Exchange the names of the two files.");
  }
  if (p[3] < q[3]) {
    right.fail(fmt::format("has a positive Tx of {:.6g} in 'projection_matrix': a negative baseline.", q[3] - p[3]),
               "Left and right are swapped: Tx of the right camera is −fx·baseline. Exchange the cameras and calibrate "
               "again, or correct the sign.");
  }
}

/// Of rectified images, as the projections have it. `shift_m`: how far right of the right camera the left one is.
void take_rectified(Calibration& calibration, const YamlGroup& right, const std::vector<double>& p,
                    const std::vector<double>& q, double shift_m) {
  if (std::abs(p[0] - q[0]) > 0.01 || std::abs(p[2] - q[2]) > 0.01) {
    right.fail("has another focal length or centre along u in 'projection_matrix' than the left camera's.",
               "Rectify with equal centres (CALIB_ZERO_DISPARITY), or give the raw images.");
  }
  calibration.rig.focal_px = p[0];
  calibration.rig.centre_u_px = p[2];
  calibration.rig.centre_v_px = p[6];
  calibration.rig.baseline_m = -shift_m;
  calibration.notes.emplace_back("images: rectified, as calibration.yaml says");
}

/// Points of both cameras before rectification: R of either takes them to the rectified one, x_rectified = R x.
void take_raw(Calibration& calibration, const YamlGroup& left, const YamlGroup& right, double shift_m) {
  const auto turn_of{[](const YamlGroup& file) {
    return rotation_of(file.matrix("rectification_matrix", 3, 3), file, "rectification_matrix");
  }};
  const cv::Matx33d right_turn{turn_of(right)};
  RawPair raw;
  raw.left = camera_of(left);
  raw.right = camera_of(right);
  set_transform(raw, right_turn.t() * turn_of(left), right_turn.t() * cv::Vec3d{shift_m, 0, 0});
  calibration.raw = raw;
}

/// Is it the same whether the images are raw or rectified?
bool is_of_both(const Calibration& calibration, const std::vector<double>& p) {
  const Rig& rig{calibration.rig};
  return !calibration.raw && std::abs(rig.focal_px - p[0]) <= 0.01 && std::abs(rig.centre_u_px - p[2]) <= 0.01 &&
         std::abs(rig.centre_v_px - p[6]) <= 0.01;
}

}  // namespace

Calibration read_ros_calibration(const YamlGroup& left, const YamlGroup& right, const CalibrationRequest& request) {
  Calibration calibration;
  calibration.kind = "ROS camera_info";
  calibration.rig.width_px = left.pixels("image_width");
  calibration.rig.height_px = left.pixels("image_height");
  check_size(left, right, calibration.rig);
  const std::vector<double> p{projection_of(left)};
  const std::vector<double> q{projection_of(right)};
  check_pair(left, right, p, q);
  double shift_m{q[3] / q[0] - p[3] / p[0]};
  if (shift_m == 0 && request.baseline_m) shift_m = -1;  // its length is taken from calibration.yaml
  if (shift_m == 0) {
    right.fail("has the same Tx in 'projection_matrix' as the left camera: the baseline is zero.",
               "Tx of the right camera is −fx·baseline. " + std::string{calibrate_together} +
                   " Or name the file in a calibration.yaml with 'baseline_m'.");
  }
  if (request.images_are_raw == false) {
    take_rectified(calibration, right, p, q, shift_m);
    take_unit(calibration, right, request);
    return calibration;
  }
  take_raw(calibration, left, right, shift_m);
  take_unit(calibration, right, request);
  take_rig_of_raw(calibration, left, request);
  if (!request.images_are_raw && !is_of_both(calibration, p)) {
    calibration.notes.emplace_back(
        "images: taken as raw. If they are rectified (image_rect), name the file in a calibration.yaml with 'images: "
        "rectified' (docs/input.md)");
  }
  return calibration;
}

}  // namespace stereogrid::io
