// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

constexpr RosTerms of_blocks{"K", "D", "R", "P", "", " Or name the file in a calibration.yaml with 'baseline_m'."};

std::string type_of(const YamlGroup& root) {
  return root.has("Camera.type") ? root.word("Camera.type") : "PinHole";
}

/// Camera with the keys Camera.fx, Camera1.fx or Camera2.fx and so on.
CameraModel camera_of(const YamlGroup& root, const std::string& name) {
  const auto number{[&](const char* key) { return root.number((name + "." + key).c_str()); }};
  const auto has{[&](const char* key) { return root.has((name + "." + key).c_str()); }};
  CameraModel camera{number("fx"), number("fy"), number("cx"), number("cy"), {}};
  const std::string type{type_of(root)};
  if (type == "Rectified" || !has("k1")) return camera;
  if (type == "KannalaBrandt8") {
    camera.lens = LensModel::fisheye;
    camera.distortion = {number("k1"), number("k2"), number("k3"), number("k4")};
  } else {
    camera.distortion = {number("k1"), number("k2"), number("p1"), number("p2")};
    if (has("k3")) camera.distortion.push_back(number("k3"));
  }
  return camera;
}

template <std::size_t size>
std::array<double, size> array_of(const std::vector<double>& numbers) {
  std::array<double, size> array{};
  std::copy_n(numbers.begin(), size, array.begin());
  return array;
}

/// LEFT.K and so on: what ORB-SLAM2 rectifies with.
RosCamera block_of(const YamlGroup& root, const std::string& side) {
  const auto key{[&](const char* name) { return side + "." + name; }};
  RosCamera camera;
  camera.width_px = root.pixels(key("width").c_str());
  camera.height_px = root.pixels(key("height").c_str());
  camera.k = array_of<9>(root.matrix(key("K").c_str(), 3, 3));
  camera.d = root.vector(key("D").c_str());
  camera.r = array_of<9>(root.matrix(key("R").c_str(), 3, 3));
  camera.p = array_of<12>(root.matrix(key("P").c_str(), 3, 4));
  if (camera.d.size() > 5) camera.distortion_model = "rational_polynomial";
  return camera;
}

Calibration read_blocks(const YamlGroup& root, const CalibrationRequest& request) {
  const Origin left{root.file(), "LEFT"};
  const Origin right{root.file(), "RIGHT"};
  Calibration calibration{ros_pair({block_of(root, "LEFT"), left}, {block_of(root, "RIGHT"), right}, of_blocks, false,
                                   request.baseline_m.has_value())};
  calibration.kind = "ORB-SLAM settings";
  take_unit(calibration, right, request);
  take_rig_of_raw(calibration, left, request);
  return calibration;
}

cv::Matx44d right_from_left(const YamlGroup& root, const CameraModel& left) {
  for (const char* const key : {"Stereo.T_c1_c2", "Tlr"}) {
    if (root.has(key)) return inverse(rigid_of(root.values(key), root, key));
  }
  cv::Matx44d transform{cv::Matx44d::eye()};
  if (root.has("Stereo.b")) {
    transform(0, 3) = -root.number("Stereo.b");
  } else if (root.has("Camera.bf")) {
    transform(0, 3) = -root.number("Camera.bf") / left.focal_u_px;
  } else {
    root.fail("has no baseline: none of 'Camera.bf', 'Stereo.b', 'Stereo.T_c1_c2' and 'Tlr'.",
              "Give the settings of a stereo camera.");
  }
  return transform;
}

}  // namespace

Calibration read_orbslam_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  if (root.has("LEFT.K") && root.has("RIGHT.K")) return read_blocks(root, request);
  const CameraModel left{camera_of(root, root.has("Camera1.fx") ? "Camera1" : "Camera")};
  const CameraModel right{root.has("Camera2.fx") ? camera_of(root, "Camera2") : left};
  check_camera(left, root);
  Calibration calibration;
  calibration.kind = "ORB-SLAM settings";
  if (root.has("Camera.width") && root.has("Camera.height")) {
    calibration.rig.width_px = root.pixels("Camera.width");
    calibration.rig.height_px = root.pixels("Camera.height");
  }
  const bool has_baseline{root.has("Stereo.b") || root.has("Camera.bf") || root.has("Stereo.T_c1_c2") ||
                          root.has("Tlr")};
  if (request.has_depth && !has_baseline) {
    take_single(calibration, left, root, request);
  } else {
    take_pair(calibration, left, right, right_from_left(root, left), root, request);
  }
  return calibration;
}

}  // namespace stereogrid::io
