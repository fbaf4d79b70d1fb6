// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

CameraModel camera_of(const YamlGroup& file) {
  const std::string type{file.has("model_type") ? file.word("model_type") : "PINHOLE"};
  const YamlGroup projection{file.group("projection_parameters")};
  if (type == "KANNALA_BRANDT") {
    return {projection.number("mu"),
            projection.number("mv"),
            projection.number("u0"),
            projection.number("v0"),
            {projection.number("k2"), projection.number("k3"), projection.number("k4"), projection.number("k5")},
            LensModel::fisheye};
  }
  if (type != "PINHOLE") {
    file.fail(fmt::format("has 'model_type' {} (allowed: PINHOLE, KANNALA_BRANDT).", type),
              "Calibrate with one of these.");
  }
  const YamlGroup bent{file.group("distortion_parameters")};
  return {projection.number("fx"),
          projection.number("fy"),
          projection.number("cx"),
          projection.number("cy"),
          {bent.number("k1"), bent.number("k2"), bent.number("p1"), bent.number("p2")}};
}

}  // namespace

Calibration read_vins_calibration(const YamlGroup& root, const std::filesystem::path& path,
                                  const CalibrationRequest& request) {
  const auto camera_file{[&](const char* key) { return read_yaml(path.parent_path() / root.file_name(key)); }};
  const YamlGroup cam0{camera_file("cam0_calib")};
  const YamlGroup cam1{camera_file("cam1_calib")};
  const auto body_from{[&](const char* key) { return rigid_of(root.matrix(key, 4, 4), root, key); }};
  const cv::Matx44d cam1_from_cam0{inverse(body_from("body_T_cam1")) * body_from("body_T_cam0")};
  const bool is_cam0_left{cam1_from_cam0(0, 3) <= 0};
  Calibration calibration;
  calibration.kind = "VINS-Fusion configuration";
  calibration.rig.width_px = cam0.pixels("image_width");
  calibration.rig.height_px = cam0.pixels("image_height");
  calibration.notes.push_back(fmt::format("cameras: {} is the left one, as 'body_T_cam0' and 'body_T_cam1' say",
                                          is_cam0_left ? "cam0" : "cam1"));
  take_pair(calibration, camera_of(is_cam0_left ? cam0 : cam1), camera_of(is_cam0_left ? cam1 : cam0),
            is_cam0_left ? cam1_from_cam0 : inverse(cam1_from_cam0), root, request);
  return calibration;
}

bool is_vins_camera(const YamlGroup& root) {
  return root.has("projection_parameters") || (root.has("model_type") && root.has("image_width"));
}

}  // namespace stereogrid::io
