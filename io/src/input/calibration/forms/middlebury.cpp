// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {

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
