// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

const char* const use_other_model{"Calibrate with --models pinhole-radtan or pinhole-equi."};
const char* const invert{"T_cn_cnm1 takes points from cam0 to cam1: invert it."};

LensModel lens_of(const YamlGroup& camera) {
  if (camera.word("camera_model") != "pinhole") {
    camera.fail("has a 'camera_model' other than pinhole, whose images cannot be rectified here.", use_other_model);
  }
  const std::string distortion{camera.word("distortion_model")};
  if (distortion == "equidistant") return LensModel::fisheye;
  if (distortion != "radtan" && distortion != "none") {
    camera.fail("has a 'distortion_model' that is none of radtan, equidistant and none.", use_other_model);
  }
  return LensModel::perspective;
}

CameraModel camera_of(const YamlGroup& camera) {
  const LensModel lens{lens_of(camera)};
  const std::vector<double> k{camera.numbers("intrinsics", 4)};
  const bool is_bent{camera.word("distortion_model") != "none"};
  CameraModel model{k[0], k[1], k[2], k[3], is_bent ? camera.numbers("distortion_coeffs", 4) : std::vector<double>{},
                    lens};
  check_camera(model, camera);
  return model;
}

cv::Matx44d transform_of(const YamlGroup& camera, const char* key) {
  return rigid_of(camera.numbers(key, 16), camera, key);
}

bool has_imu(const YamlGroup& camera) {
  return camera.has("T_cam_imu") || camera.has("T_imu_cam");
}

cv::Matx44d camera_from_imu(const YamlGroup& camera) {
  return camera.has("T_cam_imu") ? transform_of(camera, "T_cam_imu") : inverse(transform_of(camera, "T_imu_cam"));
}

/// Takes points of one camera to another: through the chain of T_cn_cnm1, else through the IMU.
cv::Matx44d second_from_first(const YamlGroup& root, int first, int second) {
  const auto camera_at{[&](int i) { return root.group(fmt::format("cam{}", i).c_str()); }};
  cv::Matx44d transform{cv::Matx44d::eye()};
  for (int i{first + 1}; i <= second; ++i) {
    const YamlGroup camera{camera_at(i)};
    if (!camera.has("T_cn_cnm1") && has_imu(camera_at(first)) && has_imu(camera_at(second))) {
      return camera_from_imu(camera_at(second)) * inverse(camera_from_imu(camera_at(first)));
    }
    transform = transform_of(camera, "T_cn_cnm1") * transform;
  }
  return transform;
}

/// Tests the direction of T_cn_cnm1 with the poses of both cameras on an IMU, if present.
bool contradicts_imu(const cv::Matx44d& cam1_from_cam0, const YamlGroup& cam0, const YamlGroup& cam1) {
  if (!has_imu(cam0) || !has_imu(cam1)) return false;
  const cv::Matx44d expected{camera_from_imu(cam1) * inverse(camera_from_imu(cam0))};
  const auto off{[&](const cv::Matx44d& transform) { return cv::norm(transform - expected); }};
  const double as_inverse{off(inverse(cam1_from_cam0))};
  return as_inverse < 0.1 * off(cam1_from_cam0) && as_inverse < 0.05;
}

/// Tests the direction with the names of topics.
bool contradicts_topics(bool is_cam0_left, const YamlGroup& cam0, const YamlGroup& cam1) {
  if (!cam0.has("rostopic") || !cam1.has("rostopic")) return false;
  const auto says{[](const YamlGroup& camera, const char* side) {
    return camera.word("rostopic").find(side) != std::string::npos;
  }};
  return (says(cam0, "right") && says(cam1, "left") && is_cam0_left) ||
         (says(cam0, "left") && says(cam1, "right") && !is_cam0_left);
}

void take_size(Rig& rig, const YamlGroup& cam0, const YamlGroup& cam1) {
  const std::vector<double> size{cam0.numbers("resolution", 2)};
  constexpr double most_px{100'000};
  const auto is_size{[](double number) { return number >= 1 && number <= most_px && number == std::floor(number); }};
  if (!is_size(size[0]) || !is_size(size[1])) cam0.fail("has a 'resolution' that is none.");
  if (cam1.numbers("resolution", 2) != size) {
    cam1.fail("has another 'resolution' than cam0.", "Both cameras' images have the same size: calibrate such ones.");
  }
  rig.width_px = static_cast<int>(size[0]);
  rig.height_px = static_cast<int>(size[1]);
}

}  // namespace

Calibration read_kalibr_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  const auto [first_number, second_number]{request.cameras};
  const std::string first_name{fmt::format("cam{}", first_number)};
  const std::string second_name{fmt::format("cam{}", second_number)};
  const YamlGroup cam0{root.group(first_name.c_str())};
  const YamlGroup cam1{root.group(second_name.c_str())};
  Calibration calibration;
  calibration.kind = "Kalibr camchain";
  take_size(calibration.rig, cam0, cam1);
  const CameraModel first{camera_of(cam0)};
  const CameraModel second{camera_of(cam1)};
  const cv::Matx44d cam1_from_cam0{second_from_first(root, first_number, second_number)};
  const bool is_cam0_left{cam1_from_cam0(0, 3) <= 0};
  if (cam1.has("T_cn_cnm1") && second_number == first_number + 1 && contradicts_imu(cam1_from_cam0, cam0, cam1)) {
    cam1.fail("has a 'T_cn_cnm1' that is the inverse of what the transforms to the IMU say.", invert);
  }
  if (contradicts_topics(is_cam0_left, cam0, cam1)) {
    cam1.fail(fmt::format("has a 'T_cn_cnm1' that puts cam1 {} of cam0, but their topics say otherwise: it looks like "
                          "the inverse.",
                          is_cam0_left ? "right" : "left"),
              std::string{invert} + " Or correct 'rostopic'.");
  }
  const cv::Matx44d right_from_left{is_cam0_left ? cam1_from_cam0 : inverse(cam1_from_cam0)};
  RawPair raw;
  raw.left = is_cam0_left ? first : second;
  raw.right = is_cam0_left ? second : first;
  set_transform(raw, right_from_left.get_minor<3, 3>(0, 0),
                {right_from_left(0, 3), right_from_left(1, 3), right_from_left(2, 3)});
  calibration.raw = raw;
  calibration.notes.push_back(fmt::format("cameras: {} is the left one and {} the right one, as their transforms say{}",
                                          is_cam0_left ? first_name : second_name,
                                          is_cam0_left ? second_name : first_name,
                                          root.has("cam2") ? "; others are not used" : ""));
  take_unit(calibration, cam1, request);
  take_rig_of_raw(calibration, cam1, request);
  return calibration;
}

}  // namespace stereogrid::io
