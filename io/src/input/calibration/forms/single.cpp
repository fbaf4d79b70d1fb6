// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/forms/opencv_names.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

using opencv::find;

// Sides that a single camera may have.
constexpr std::array<std::string_view, 10> sides{"", "color", "rgb", "camera", "left", "cam0", "0", "1", "l", "infra1"};

std::optional<CameraModel> camera_with(const YamlGroup& file, std::string_view side) {
  const std::string matrix{find(file, opencv::matrix_names, side)};
  const std::array<std::string, 4> keys{find(file, opencv::fx_names, side), find(file, opencv::fy_names, side),
                                        find(file, opencv::cx_names, side), find(file, opencv::cy_names, side)};
  CameraModel camera;
  if (!matrix.empty()) {
    const std::vector<double> k{file.values(matrix.c_str())};
    if (k.size() == 9) {
      camera = camera_of(k, file, matrix.c_str());
    } else if (k.size() == 12 || k.size() == 16) {  // 3 or 4 rows of 4
      camera = camera_of({k[0], k[1], k[2], k[4], k[5], k[6], k[8], k[9], k[10]}, file, matrix.c_str());
    } else {
      return std::nullopt;
    }
  } else if (std::ranges::none_of(keys, &std::string::empty)) {
    camera = {file.number(keys[0].c_str()),
              file.number(keys[1].c_str()),
              file.number(keys[2].c_str()),
              file.number(keys[3].c_str()),
              {}};
  } else {
    return std::nullopt;
  }
  if (const std::string d{find(file, opencv::distortion_names, side)}; !d.empty())
    camera.distortion = file.vector(d.c_str());
  return camera;
}

}  // namespace

std::optional<Calibration> read_single_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  const YamlGroup file{root.flat()};
  for (const std::string_view side : sides) {
    const auto camera{camera_with(file, side)};
    if (!camera) continue;
    Calibration calibration;
    calibration.kind = "intrinsics of one camera";
    const std::string width{find(file, opencv::width_names, side)};
    const std::string height{find(file, opencv::height_names, side)};
    if (!width.empty() && !height.empty()) {
      calibration.rig.width_px = file.pixels(width.c_str());
      calibration.rig.height_px = file.pixels(height.c_str());
    }
    take_single(calibration, *camera, file, request);
    return calibration;
  }
  return std::nullopt;
}

void take_single(Calibration& calibration, const CameraModel& camera, const Origin& origin,
                 const CalibrationRequest& request) {
  check_camera(camera, origin);
  const bool has_distortion{std::ranges::any_of(camera.distortion, [](double d) { return d != 0; })};
  if (!request.has_depth && has_distortion) {
    origin.fail("is the calibration of one raw camera, with distortion.",
                "Calibrate both cameras together, or rectify the pair.");
  }
  const int width_px{calibration.rig.width_px > 0 ? calibration.rig.width_px : request.width_px};
  const double baseline_m{request.baseline_m.value_or(virtual_baseline_m(camera.focal_u_px, width_px))};
  cv::Matx44d right_from_left{cv::Matx44d::eye()};
  right_from_left(0, 3) = -baseline_m;
  take_pair(calibration, camera, camera, right_from_left, origin, request);
  if (request.baseline_m) return;
  calibration.notes.push_back(fmt::format(
      "baseline: the calibration has none; depth becomes disparities of a virtual one of {:.4g} m", baseline_m));
}

double virtual_baseline_m(double focal_px, int width_px) {
  constexpr double nearest_m{0.5};
  const double nearest_px{std::max(60.0, width_px / 10.0 - 4)};
  return nearest_m * nearest_px / focal_px;
}

}  // namespace stereogrid::io
