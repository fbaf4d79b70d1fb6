// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

constexpr RosTerms of_files{
    "camera_matrix",
    "distortion_coefficients",
    "rectification_matrix",
    "projection_matrix",
    " Or, where the images are rectified, name this file in a calibration.yaml with 'images: rectified'.",
    " Or name the file in a calibration.yaml with 'baseline_m'."};

template <std::size_t size>
std::array<double, size> array_of(const std::vector<double>& numbers) {
  std::array<double, size> array{};
  std::copy_n(numbers.begin(), size, array.begin());
  return array;
}

/// Rectified images need the projection alone.
RosCamera camera_of(const YamlGroup& file, bool are_rectified) {
  RosCamera camera;
  camera.width_px = file.pixels("image_width");
  camera.height_px = file.pixels("image_height");
  if (!file.has("projection_matrix")) {
    file.fail("has no 'projection_matrix': it is of a single camera.", calibrate_together);
  }
  camera.p = array_of<12>(file.matrix("projection_matrix", 3, 4));
  if (are_rectified) return camera;
  camera.k = array_of<9>(file.matrix("camera_matrix", 3, 3));
  camera.r = array_of<9>(file.matrix("rectification_matrix", 3, 3));
  if (file.has("distortion_model")) camera.distortion_model = file.word("distortion_model");
  const auto lens{file.has("camera_model") ? lens_named(file.word("camera_model")) : std::nullopt};
  if (lens == LensModel::fisheye) camera.distortion_model = "equidistant";
  camera.d = file.vector("distortion_coefficients");
  return camera;
}

/// True if raw and rectified images are the same.
bool is_of_both(const Calibration& calibration, const std::array<double, 12>& p) {
  const Rig& rig{calibration.rig};
  return !calibration.raw && std::abs(rig.focal_px - p[0]) <= 0.01 && std::abs(rig.cx_px - p[2]) <= 0.01 &&
         std::abs(rig.cy_px - p[6]) <= 0.01;
}

}  // namespace

Calibration read_ros_calibration(const YamlGroup& left, const YamlGroup& right, const CalibrationRequest& request) {
  const bool are_rectified{request.images_are_raw == false};
  const RosCamera left_camera{camera_of(left, are_rectified)};
  const RosCamera right_camera{camera_of(right, are_rectified)};
  Calibration calibration{
      ros_pair({left_camera, left}, {right_camera, right}, of_files, are_rectified, request.baseline_m.has_value())};
  calibration.kind = "ROS camera_info";
  take_unit(calibration, right, request);
  if (are_rectified) {
    calibration.notes.emplace_back("images: rectified, as calibration.yaml says");
    if (calibration.raw) take_rig_of_raw(calibration, left, request);
    return calibration;
  }
  take_rig_of_raw(calibration, left, request);
  if (!request.images_are_raw && !is_of_both(calibration, left_camera.p)) {
    calibration.notes.emplace_back(
        "images: taken as raw. If they are rectified (image_rect), name the file in a calibration.yaml with 'images: "
        "rectified' (docs/input.md)");
  }
  return calibration;
}

}  // namespace stereogrid::io
