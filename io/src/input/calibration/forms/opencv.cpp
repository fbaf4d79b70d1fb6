// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/forms/opencv_names.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

using namespace opencv;

bool has(const YamlGroup& file, Names names, std::string_view side = "") {
  return !find(file, names, side).empty();
}

/// fx, fy, cx and cy on their own, as librealsense names them, too.
CameraModel model_of_numbers(const YamlGroup& file, std::string_view side) {
  const auto number{[&](Names names) {
    const std::string key{find(file, names, side)};
    if (key.empty()) file.fail(fmt::format("has no '{}{}'.", names.front(), side), "fx, fy, cx and cy are needed.");
    return file.number(key.c_str());
  }};
  return {number(fx_names), number(fy_names), number(cx_names), number(cy_names), {}};
}

CameraModel camera_of(const YamlGroup& file, std::string_view side, std::optional<LensModel> lens) {
  const std::string matrix{find(file, matrix_names, side)};
  const std::string distortion{find(file, distortion_names, side)};
  if (!matrix.empty() && distortion.empty()) {
    file.fail(fmt::format("has no 'D{}'.", side), "Write both cameras' distortion, five zeros where there is none.");
  }
  CameraModel camera{matrix.empty() ? model_of_numbers(file, side)
                                    : io::camera_of(file.matrix(matrix.c_str(), 3, 3), file, matrix.c_str())};
  if (!distortion.empty()) camera.distortion = file.vector(distortion.c_str());
  camera.lens = lens.value_or(LensModel::perspective);
  check_camera(camera, file);
  return camera;
}

/// Lens of both cameras by the file's words, or as requested; none: not named.
std::optional<LensModel> lens_of(const YamlGroup& file, const Sides* sides, const CalibrationRequest& request) {
  if (request.lens) return request.lens;
  std::string key{find(file, lens_names)};
  if (key.empty() && sides != nullptr) key = find(file, lens_names, sides->left);
  return key.empty() ? std::nullopt : lens_named(file.word(key.c_str()));
}

/// cv::fisheye has four coefficients, too, and its dumps the same keys.
bool may_be_fisheye(const CameraModel& camera) {
  constexpr std::size_t fisheye_count{4};
  const auto is_zero{[](double number) { return number == 0; }};
  return camera.distortion.size() == fisheye_count && !std::ranges::all_of(camera.distortion, is_zero);
}

/// Value for all cameras, else that of the left one.
void read_size(const YamlGroup& root, const Sides* sides, Rig& rig) {
  const auto key_of{[&](Names names) {
    std::string key{find(root, names)};
    return key.empty() && sides != nullptr ? find(root, names, sides->left) : key;
  }};
  const std::string size{key_of(size_names)};
  const std::string width{key_of(width_names)};
  const std::string height{key_of(height_names)};
  if (!width.empty() && !height.empty()) {
    rig.width_px = root.pixels(width.c_str());
    rig.height_px = root.pixels(height.c_str());
  } else if (!size.empty()) {
    const std::vector<double> both{root.values(size.c_str())};
    if (both.size() != 2) root.fail(fmt::format("'{}' has {} numbers, not 2.", size, both.size()));
    constexpr double most_px{100'000};
    for (const double number : both) {
      if (!(number >= 1 && number <= most_px)) root.fail(fmt::format("'{}' is not a size in pixels.", size));
    }
    rig.width_px = static_cast<int>(both[0]);
    rig.height_px = static_cast<int>(both[1]);
  }
}

/// Metres in the file's unit of length.
double unit_of(const YamlGroup& file) {
  const std::string key{find(file, unit_names)};
  const std::string unit{key.empty() ? "m" : file.word(key.c_str())};
  if (unit == "m" || unit.starts_with("met")) return 1;
  if (unit == "mm" || unit.starts_with("mill")) return 1e-3;
  if (unit == "cm" || unit.starts_with("cent")) return 1e-2;
  file.fail(fmt::format("has the unit '{}' (allowed: m, cm, mm).", unit), "Correct it.");
}

cv::Matx44d right_from_left(const YamlGroup& file) {
  const double unit_m{unit_of(file)};
  const std::string r{find(file, rotation_names)};
  const std::string t{find(file, translation_names)};
  if (r.empty() && t.empty() && has(file, baseline_names)) {
    const double baseline{std::abs(file.number(find(file, baseline_names).c_str()))};
    return rigid_of(cv::Matx33d::eye(), {-baseline * unit_m, 0, 0});
  }
  if (r.empty()) file.fail("has no 'R', the rotation from camera 1 to camera 2.");
  if (t.empty()) file.fail("has no 'T', the translation from camera 1 to camera 2.");
  const std::vector<double> shift{file.vector(t.c_str())};
  if (shift.size() != 3) file.fail(fmt::format("has in '{}' a translation that is not 3 numbers.", t));
  cv::Matx33d turn{rotation_of(file.values(r.c_str()), file, r.c_str())};
  const bool is_by_columns{sides_of(file, std::span{cx_names}.subspan(1, 1)) != nullptr};  // librealsense
  if (is_by_columns) turn = turn.t();
  return rigid_of(turn, unit_m * cv::Vec3d{shift[0], shift[1], shift[2]});
}

/// P1 and P2 of stereoRectify, else Q.
void take_projections(Calibration& calibration, const YamlGroup& file) {
  Rig rig;
  double right_cx_px{0};
  if (const Sides* const sides{sides_of(file, projection_names)}) {
    const std::vector<double> left{file.matrix(find(file, projection_names, sides->left).c_str(), 3, 4)};
    const std::string name{find(file, projection_names, sides->right)};
    const std::vector<double> right{file.matrix(name.c_str(), 3, 4)};
    const auto differ{[&](std::size_t i) { return std::abs(left[i] - right[i]) > 0.01; }};
    if (!(left[0] >= 1) || differ(0) || differ(5) || differ(6)) {
      file.fail(fmt::format("has another focal length or cy in '{}' than in that of the left camera, or none.", name),
                "P1 and P2 of stereoRectify have them alike.");
    }
    rig.focal_px = left[0];
    rig.cx_px = left[2];
    rig.cy_px = left[6];
    rig.baseline_m = unit_of(file) * (left[3] - right[3]) / left[0];
    right_cx_px = right[2];
  } else {
    const std::vector<double> q{file.matrix(find(file, reprojection_names).c_str(), 4, 4)};
    if (!(q[11] >= 1) || q[14] == 0)
      file.fail("has no focal length or no baseline in 'Q'.", "Give that of stereoRectify.");
    rig.focal_px = q[11];
    rig.cx_px = -q[3];
    rig.cy_px = -q[7];
    rig.baseline_m = unit_of(file) / std::abs(q[14]);
    right_cx_px = rig.cx_px + q[15] / q[14];
  }
  take_row_aligned(calibration, rig, right_cx_px);
}

}  // namespace

std::optional<LensModel> lens_named(std::string_view word) {
  std::string text{word};
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto has{[&](const char* part) { return text.find(part) != std::string::npos; }};
  if (has("fish") || has("equi") || text == "kb4" || has("kannala")) return LensModel::fisheye;
  if (has("pinhole") || has("perspective") || has("plumb") || has("rad") || has("brown")) return LensModel::perspective;
  return std::nullopt;
}

OpencvParts opencv_parts(const YamlGroup& root) {
  const YamlGroup file{root.flat()};
  const bool has_both{sides_of(file, matrix_names) != nullptr || sides_of(file, fx_names) != nullptr};
  const bool has_transform{has(file, rotation_names) && has(file, translation_names)};
  const bool has_baseline{has(file, baseline_names) && (has_both || has(file, fx_names))};
  const bool is_half{has(file, rotation_names) || has(file, translation_names)};  // one of two files
  const bool has_projections{sides_of(file, projection_names) != nullptr || has(file, reprojection_names)};
  return {has_both || has_baseline, has_transform || has_baseline, has_projections && !is_half};
}

Calibration read_opencv_projections(const YamlGroup& root, const CalibrationRequest& request) {
  const YamlGroup file{root.flat()};
  Calibration calibration;
  calibration.kind = "OpenCV stereo rectification";
  read_size(file, nullptr, calibration.rig);
  take_projections(calibration, file);
  calibration.notes.emplace_back("images: taken as rectified; the file has no calibration of raw ones");
  take_unit(calibration, file, request);
  return calibration;
}

Calibration read_opencv_calibration(const YamlGroup& intrinsics, const YamlGroup& extrinsics,
                                    const CalibrationRequest& request) {
  const YamlGroup cameras{intrinsics.flat()};
  const YamlGroup between{extrinsics.flat()};
  Calibration calibration;
  calibration.kind = "OpenCV stereo calibration";
  const Sides* sides{sides_of(cameras, matrix_names)};
  if (sides == nullptr) sides = sides_of(cameras, fx_names);
  if (sides == nullptr && !has(cameras, fx_names)) {
    intrinsics.fail("has no 'M1' or 'M2', the camera matrices.", "Both cameras are needed.");
  }
  read_size(cameras, sides, calibration.rig);
  const auto lens{lens_of(cameras, sides, request)};
  const CameraModel left{camera_of(cameras, sides == nullptr ? "" : sides->left, lens)};
  const CameraModel right{sides == nullptr ? left : camera_of(cameras, sides->right, lens)};
  take_pair(calibration, left, right, right_from_left(between), extrinsics, request);
  calibration.is_lens_unnamed = !lens && calibration.raw && may_be_fisheye(left) && may_be_fisheye(right);
  return calibration;
}

}  // namespace stereogrid::io
