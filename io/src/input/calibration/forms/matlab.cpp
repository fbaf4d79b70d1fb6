// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

const char* const convert{
    "Write it with jsonencode(toStruct(stereoParams)), or as OpenCV's with stereoParametersToOpenCV."};

/// Before R2022b matrices are transposed: points are rows.
bool is_transposed(const std::vector<double>& k) {
  return k[2] == 0 && k[5] == 0 && (k[6] != 0 || k[7] != 0);
}

cv::Matx33d matrix_of(const YamlGroup& camera) {
  const std::vector<double> k{camera.numbers(camera.has("K") ? "K" : "IntrinsicMatrix", 9)};
  const cv::Matx33d matrix{k.data()};
  return is_transposed(k) ? matrix.t() : matrix;
}

/// Centres of pixels begin at 1.
CameraModel camera_of(const YamlGroup& camera) {
  const cv::Matx33d k{matrix_of(camera)};
  CameraModel model{k(0, 0), k(1, 1), k(0, 2) - 1, k(1, 2) - 1, {}};
  const std::vector<double> radial{camera.numbers("RadialDistortion")};
  const std::vector<double> tangential{camera.numbers("TangentialDistortion", 2)};
  if (radial.size() < 2 || radial.size() > 3) camera.fail("has not 2 or 3 numbers in 'RadialDistortion'.", convert);
  model.distortion = {radial[0], radial[1], tangential[0], tangential[1]};
  if (radial.size() == 3) model.distortion.push_back(radial[2]);
  return model;
}

double unit_of(const YamlGroup& camera) {
  const std::string unit{camera.has("WorldUnits") ? camera.word("WorldUnits") : "millimeters"};
  if (unit.starts_with("mil") || unit == "mm") return 1e-3;
  if (unit.starts_with("cen") || unit == "cm") return 1e-2;
  if (unit.starts_with("met") || unit == "m") return 1;
  if (unit.starts_with("in")) return 0.0254;
  camera.fail(fmt::format("has 'WorldUnits' {} (allowed: millimeters, centimeters, meters, inches).", unit), convert);
}

}  // namespace

Calibration read_matlab_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  const YamlGroup first{root.group("CameraParameters1")};
  const YamlGroup second{root.group("CameraParameters2")};
  if (!root.has("RotationOfCamera2") || !root.has("TranslationOfCamera2")) {
    root.fail("is MATLAB's, without 'RotationOfCamera2' and 'TranslationOfCamera2'.", convert);
  }
  const std::vector<double> k{first.numbers(first.has("K") ? "K" : "IntrinsicMatrix", 9)};
  cv::Matx33d turn{rotation_of(root.numbers("RotationOfCamera2", 9), root, "RotationOfCamera2")};
  if (is_transposed(k)) turn = turn.t();
  const std::vector<double> t{root.numbers("TranslationOfCamera2", 3)};
  Calibration calibration;
  calibration.kind = "MATLAB stereoParameters";
  if (first.has("ImageSize")) {
    const std::vector<double> rows_and_columns{first.numbers("ImageSize", 2)};
    const auto is_size{[](double number) { return number >= 1 && number <= 1e5; }};
    if (!is_size(rows_and_columns[0]) || !is_size(rows_and_columns[1]))
      first.fail("has no size in 'ImageSize'.", convert);
    calibration.rig.height_px = static_cast<int>(rows_and_columns[0]);
    calibration.rig.width_px = static_cast<int>(rows_and_columns[1]);
  }
  take_pair(calibration, camera_of(first), camera_of(second),
            rigid_of(turn, unit_of(first) * cv::Vec3d{t[0], t[1], t[2]}), root, request);
  return calibration;
}

}  // namespace stereogrid::io
