// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"
#include "input/calibration/rigid.hpp"

namespace stereogrid::io {
namespace {

/// What dumps of stereoCalibrate call a value, in lower case without separators.
using Names = std::span<const std::string_view>;
constexpr std::string_view matrix_names[]{"m",
                                          "k",
                                          "cameramatrix",
                                          "cammatrix",
                                          "cm",
                                          "mtx",
                                          "matrix",
                                          "intrinsic",
                                          "intrinsics",
                                          "intrinsicmatrix",
                                          "cammtx",
                                          "a",
                                          "camera",
                                          "kmatrix",
                                          "cam",
                                          "newcameramatrix",
                                          "intrinsicsmatrix"};
constexpr std::string_view distortion_names[]{"d",
                                              "dist",
                                              "distcoeffs",
                                              "distcoeff",
                                              "distcoefs",
                                              "distcoef",
                                              "distortion",
                                              "distortioncoeffs",
                                              "distcoeffsmatrix",
                                              "distortions",
                                              "distortioncoefficients",
                                              "distortionvector"};
constexpr std::string_view rotation_names[]{"r",       "rot",     "rotation",   "rotationmatrix", "rmat",
                                            "stereor", "rstereo", "extrinsicr", "rotmatrix",      "rotmat"};
constexpr std::string_view translation_names[]{"t",       "trans",   "translation", "translationvector", "tvec",
                                               "stereot", "tstereo", "extrinsict",  "transvector",       "tmat"};
constexpr std::string_view size_names[]{"imagesize", "size", "imgsize", "resolution", "framesize", "imsize"};
constexpr std::string_view width_names[]{"imagewidth", "width", "imgwidth", "imwidth"};
constexpr std::string_view height_names[]{"imageheight", "height", "imgheight", "imheight"};

struct Sides {
  std::string_view left;
  std::string_view right;
};
constexpr Sides all_sides[]{{"1", "2"}, {"0", "1"}, {"l", "r"}, {"left", "right"}};

std::string plain(const std::string& key) {
  std::string text;
  for (const unsigned char letter : key) {
    if (std::isalnum(letter) != 0) text += static_cast<char>(std::tolower(letter));
  }
  return text;
}

/// The key called by one of the names with `side` before or behind it; "": none.
std::string find(const YamlGroup& root, Names names, std::string_view side = "") {
  for (const std::string& key : root.keys()) {
    const std::string text{plain(key)};
    const auto is_name{[&](std::string_view name) {
      const std::string behind{std::string{name} + std::string{side}};
      return text == behind || text == std::string{side} + std::string{name};
    }};
    if (std::ranges::any_of(names, is_name)) return key;
  }
  return {};
}

const Sides* sides_of(const YamlGroup& root) {
  const auto has_both{[&](const Sides& sides) {
    return !find(root, matrix_names, sides.left).empty() && !find(root, matrix_names, sides.right).empty();
  }};
  const auto found{std::ranges::find_if(all_sides, has_both)};
  return found == std::end(all_sides) ? nullptr : found;
}

CameraModel camera_of(const YamlGroup& file, std::string_view side) {
  const std::string matrix{find(file, matrix_names, side)};
  const std::string distortion{find(file, distortion_names, side)};
  if (matrix.empty() || distortion.empty()) {
    file.fail(fmt::format("has no '{}{}'.", matrix.empty() ? "M" : "D", side),
              matrix.empty() ? "Both camera matrices are needed."
                             : "Write both cameras' distortion, five zeros where there is none.");
  }
  CameraModel camera{io::camera_of(file.matrix(matrix.c_str(), 3, 3), file, matrix.c_str())};
  camera.distortion = file.vector(distortion.c_str());
  check_camera(camera, file);
  return camera;
}

void read_size(const YamlGroup& root, Rig& rig) {
  const std::string size{find(root, size_names)};
  const std::string width{find(root, width_names)};
  const std::string height{find(root, height_names)};
  if (!width.empty() && !height.empty()) {
    rig.width_px = root.pixels(width.c_str());
    rig.height_px = root.pixels(height.c_str());
  } else if (!size.empty()) {
    const std::vector<double> both{root.numbers(size.c_str(), 2)};
    constexpr double most_px{100'000};
    for (const double number : both) {
      if (!(number >= 1 && number <= most_px)) root.fail(fmt::format("'{}' is no size in pixels.", size));
    }
    rig.width_px = static_cast<int>(both[0]);
    rig.height_px = static_cast<int>(both[1]);
  }
}

}  // namespace

OpencvParts opencv_parts(const YamlGroup& root) {
  return {sides_of(root) != nullptr, !find(root, rotation_names).empty() && !find(root, translation_names).empty()};
}

Calibration read_opencv_calibration(const YamlGroup& intrinsics, const YamlGroup& extrinsics,
                                    const CalibrationRequest& request) {
  Calibration calibration;
  calibration.kind = "OpenCV stereo calibration";
  const Sides* const sides{sides_of(intrinsics)};
  if (sides == nullptr) intrinsics.fail("has no 'M1' or 'M2', the camera matrices.", "Both cameras are needed.");
  const std::string r{find(extrinsics, rotation_names)};
  const std::string t{find(extrinsics, translation_names)};
  if (r.empty()) extrinsics.fail("has no 'R', the rotation from camera 1 to camera 2.");
  if (t.empty()) extrinsics.fail("has no 'T', the translation from camera 1 to camera 2.");
  const std::vector<double> shift{extrinsics.vector(t.c_str())};
  if (shift.size() != 3) extrinsics.fail(fmt::format("has in '{}' a translation that is not 3 numbers.", t));
  const std::vector<double> turn{extrinsics.values(r.c_str())};
  read_size(intrinsics, calibration.rig);
  const CameraModel left{camera_of(intrinsics, sides->left)};
  const CameraModel right{camera_of(intrinsics, sides->right)};
  take_pair(calibration, left, right,
            rigid_of(rotation_of(turn, extrinsics, r.c_str()), {shift[0], shift[1], shift[2]}), extrinsics, request);
  return calibration;
}

}  // namespace stereogrid::io
