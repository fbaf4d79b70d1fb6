// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

CameraModel camera_of(const YamlGroup& camera) {
  const std::vector<double> k{camera.numbers("intrinsics", 4)};
  CameraModel model{k[0], k[1], k[2], k[3], {}};
  const std::string type{camera.has("camera_model") ? camera.word("camera_model") : "pinhole"};
  const std::string distortion{camera.has("distortion_model") ? camera.word("distortion_model") : "none"};
  if (type != "pinhole") {
    camera.fail(fmt::format("has 'camera_model' {} (allowed: pinhole).", type), "Calibrate with a pinhole model.");
  }
  if (distortion == "none") return model;
  model.distortion =
      camera.numbers(camera.has("distortion_coefficients") ? "distortion_coefficients" : "distortion_coeffs");
  if (distortion == "equidistant") {
    model.lens = LensModel::fisheye;
  } else if (distortion != "radial-tangential" && distortion != "radtan" && distortion != "plumb_bob") {
    camera.fail(fmt::format("has 'distortion_model' {} (allowed: radial-tangential, equidistant, none).", distortion),
                "Calibrate with one of these.");
  }
  return model;
}

/// Takes points of the camera to the body.
cv::Matx44d body_from(const YamlGroup& camera) {
  return rigid_of(camera.matrix("T_BS", 4, 4), camera, "T_BS");
}

}  // namespace

Calibration read_euroc_calibration(const YamlGroup& cam0, const YamlGroup& cam1, const CalibrationRequest& request) {
  const std::vector<double> size{cam0.numbers("resolution", 2)};
  if (!(size[0] >= 1 && size[0] <= 1e5 && size[1] >= 1 && size[1] <= 1e5) || cam1.numbers("resolution", 2) != size) {
    cam1.fail("has another 'resolution' than cam0, or none in pixels.", "Both cameras' images have the same size.");
  }
  Calibration calibration;
  calibration.kind = "EuRoC sensor.yaml";
  calibration.rig.width_px = static_cast<int>(size[0]);
  calibration.rig.height_px = static_cast<int>(size[1]);
  const cv::Matx44d cam1_from_cam0{inverse(body_from(cam1)) * body_from(cam0)};
  const bool is_cam0_left{cam1_from_cam0(0, 3) <= 0};
  const CameraModel first{camera_of(cam0)};
  const CameraModel second{camera_of(cam1)};
  calibration.notes.push_back(
      fmt::format("cameras: {} is the left one, as 'T_BS' of both says", is_cam0_left ? "cam0" : "cam1"));
  take_pair(calibration, is_cam0_left ? first : second, is_cam0_left ? second : first,
            is_cam0_left ? cam1_from_cam0 : inverse(cam1_from_cam0), cam1, request);
  return calibration;
}

bool is_cam0_right(const std::filesystem::path& cam0, const std::filesystem::path& cam1) {
  try {
    return (inverse(body_from(read_yaml(cam1))) * body_from(read_yaml(cam0)))(0, 3) > 0;
  } catch (const InputError&) {  // reported where the calibration is read
    return false;
  }
}

Calibration read_middlebury_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  constexpr double mm{1e-3};
  constexpr double shortest_mm{1};  // smaller values are in metres
  const CameraModel left{camera_of(root.numbers("cam0", 9), root, "cam0")};
  CameraModel right{root.has("cam1") ? camera_of(root.numbers("cam1", 9), root, "cam1") : left};
  if (root.has("doffs")) right.cx_px = left.cx_px + root.number("doffs");
  Calibration calibration;
  calibration.kind = "Middlebury calib.txt";
  if (root.has("width") && root.has("height")) {
    calibration.rig.width_px = root.pixels("width");
    calibration.rig.height_px = root.pixels("height");
  }
  cv::Matx44d right_from_left{cv::Matx44d::eye()};
  const double baseline{root.number("baseline")};
  const bool is_in_metres{baseline > 0 && baseline < shortest_mm};
  right_from_left(0, 3) = is_in_metres ? -baseline : -mm * baseline;
  if (is_in_metres) calibration.notes.emplace_back("baseline: taken as metres; Middlebury's are millimetres");
  take_pair(calibration, left, right, right_from_left, root, request);
  return calibration;
}

}  // namespace stereogrid::io
