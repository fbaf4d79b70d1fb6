// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibration_writers.hpp"

#include <algorithm>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/persistence.hpp>

namespace stereogrid::io::testing {
namespace {

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", number);
  return text;
}

std::string list_of(const double* numbers, std::size_t count) {
  std::string text{"["};
  for (std::size_t i{0}; i < count; ++i) text += (i == 0 ? "" : ", ") + text_of(numbers[i]);
  return text + "]";
}

std::string list_of(const std::vector<double>& numbers) {
  return list_of(numbers.data(), numbers.size());
}

cv::Matx33d matrix_of(const CameraModel& c) {
  return {c.focal_u_px, 0, c.cx_px, 0, c.focal_v_px, c.cy_px, 0, 0, 1};
}

/// Turns and projections of both cameras.
struct Projections {
  cv::Mat left_turn, right_turn, left, right;
};

Projections projections_of(const CameraPair& pair) {
  const RawPair& raw{pair.cameras};
  const cv::Matx33d turn{raw.right_from_left_rotation.data()};
  const cv::Vec3d shift{raw.right_from_left_translation_m.data()};
  const cv::Size size{pair.width_px, pair.height_px};
  const cv::Matx33d k{matrix_of(raw.left)};
  Projections p;
  cv::Mat depth;
  if (raw.left.distortion.empty()) {
    p.left_turn = p.right_turn = cv::Mat{cv::Matx33d::eye()};
    cv::hconcat(k, cv::Vec3d{0, 0, 0}, p.left);
    cv::hconcat(k, k * shift, p.right);
  } else if (raw.left.lens == LensModel::fisheye) {
    cv::fisheye::stereoRectify(k, raw.left.distortion, matrix_of(raw.right), raw.right.distortion, size, turn, shift,
                               p.left_turn, p.right_turn, p.left, p.right, depth, cv::CALIB_ZERO_DISPARITY, size, 0.3);
  } else {
    cv::stereoRectify(k, raw.left.distortion, matrix_of(raw.right), raw.right.distortion, size, turn, shift,
                      p.left_turn, p.right_turn, p.left, p.right, depth, cv::CALIB_ZERO_DISPARITY, 0.5);
  }
  return p;
}

std::string ros_matrix(const char* key, int rows, int cols, const double* numbers) {
  return std::string{key} + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(cols) +
         "\n  data: " + list_of(numbers, static_cast<std::size_t>(rows * cols)) + "\n";
}

std::string ros_file(const CameraModel& camera, const CameraPair& pair, const cv::Mat& turn, const cv::Mat& p) {
  const std::vector<double> d{camera.distortion.empty() ? std::vector<double>(5) : camera.distortion};
  const char* const model{camera.lens == LensModel::fisheye ? "equidistant"
                          : d.size() > 5                    ? "rational_polynomial"
                                                            : "plumb_bob"};
  return "image_width: " + std::to_string(pair.width_px) + "\nimage_height: " + std::to_string(pair.height_px) +
         "\ncamera_name: narrow_stereo\n" + ros_matrix("camera_matrix", 3, 3, matrix_of(camera).val) +
         "distortion_model: " + model + "\n" +
         ros_matrix("distortion_coefficients", 1, static_cast<int>(d.size()), d.data()) +
         ros_matrix("rectification_matrix", 3, 3, turn.ptr<double>()) +
         ros_matrix("projection_matrix", 3, 4, p.ptr<double>());
}

std::string kalibr_camera(const CameraModel& camera, const CameraPair& pair) {
  const std::vector<double> k{camera.focal_u_px, camera.focal_v_px, camera.cx_px, camera.cy_px};
  const char* const model{camera.lens == LensModel::fisheye ? "equidistant"
                          : camera.distortion.empty()       ? "none"
                                                            : "radtan"};
  return std::string{"  cam_overlaps: [0]\n  camera_model: pinhole\n"} +
         "  distortion_coeffs: " + list_of(camera.distortion) + "\n  distortion_model: " + model +
         "\n  intrinsics: " + list_of(k) + "\n  resolution: [" + std::to_string(pair.width_px) + ", " +
         std::to_string(pair.height_px) + "]\n";
}

std::string own_camera(const CameraModel& camera) {
  return "{focal_u_px: " + text_of(camera.focal_u_px) + ", focal_v_px: " + text_of(camera.focal_v_px) +
         ", cx_px: " + text_of(camera.cx_px) + ", cy_px: " + text_of(camera.cy_px) +
         ", distortion: " + list_of(camera.distortion) +
         (camera.lens == LensModel::fisheye ? ", lens: fisheye}\n" : "}\n");
}

}  // namespace

Files ros_files(const CameraPair& pair) {
  const Projections p{projections_of(pair)};
  return {{"left.yaml", ros_file(pair.cameras.left, pair, p.left_turn, p.left)},
          {"right.yaml", ros_file(pair.cameras.right, pair, p.right_turn, p.right)}};
}

Files opencv_files(const CameraPair& pair) {
  const auto distortion_of{[](const CameraModel& camera) {
    return cv::Mat{camera.distortion.empty() ? std::vector<double>(5) : camera.distortion, true}.t();
  }};
  constexpr int mode{cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML};
  const RawPair& raw{pair.cameras};
  cv::FileStorage intrinsics{"", mode};
  intrinsics << "M1" << cv::Mat{matrix_of(raw.left)} << "D1" << cv::Mat{distortion_of(raw.left)};
  intrinsics << "M2" << cv::Mat{matrix_of(raw.right)} << "D2" << cv::Mat{distortion_of(raw.right)};
  const Projections p{projections_of(pair)};
  cv::FileStorage extrinsics{"", mode};
  extrinsics << "R" << cv::Mat{cv::Matx33d{raw.right_from_left_rotation.data()}};
  extrinsics << "T" << cv::Mat{cv::Vec3d{raw.right_from_left_translation_m.data()}};
  extrinsics << "R1" << p.left_turn << "R2" << p.right_turn << "P1" << p.left << "P2" << p.right;
  return {{"intrinsics.yml", intrinsics.releaseAndGetString()}, {"extrinsics.yml", extrinsics.releaseAndGetString()}};
}

Files kalibr_files(const CameraPair& pair) {
  const auto& r{pair.cameras.right_from_left_rotation};
  const auto& t{pair.cameras.right_from_left_translation_m};
  std::string transform{"  T_cn_cnm1:\n"};
  for (std::size_t i{0}; i < 3; ++i) {
    transform += "  - " + list_of({r[3 * i], r[3 * i + 1], r[3 * i + 2], t[i]}) + "\n";
  }
  return {{"camchain.yaml", "cam0:\n" + kalibr_camera(pair.cameras.left, pair) +
                                "  rostopic: /left/image_raw\ncam1:\n" + transform + "  - [0.0, 0.0, 0.0, 1.0]\n" +
                                kalibr_camera(pair.cameras.right, pair) + "  rostopic: /right/image_raw\n"}};
}

Files own_files(const CameraPair& pair) {
  const RawPair& raw{pair.cameras};
  return {{"calibration.yaml",
           "image: {width_px: " + std::to_string(pair.width_px) + ", height_px: " + std::to_string(pair.height_px) +
               "}\nleft: " + own_camera(raw.left) + "right: " + own_camera(raw.right) +
               "right_from_left:\n  rotation: " + list_of(raw.right_from_left_rotation.data(), 9) +
               "\n  translation_m: " + list_of(raw.right_from_left_translation_m.data(), 3) + "\n"}};
}

void put_files(const fs::path& folder, const Files& files) {
  for (const auto& [name, text] : files) put(folder / name, text);
}

CameraPair rectified_pair(const Rig& rig) {
  const CameraModel camera{rig.focal_px, rig.focal_px, rig.cx_px, rig.cy_px, {}};
  CameraPair pair{{camera, camera}, rig.width_px, rig.height_px};
  pair.cameras.right_from_left_translation_m = {-rig.baseline_m, 0, 0};
  return pair;
}

CameraPair raw_pair(std::vector<double> left_distortion, std::vector<double> right_distortion, LensModel lens) {
  CameraPair pair;
  pair.cameras.left = {250, 251, 161, 118, std::move(left_distortion), lens};
  pair.cameras.right = {253, 252, 157, 120, std::move(right_distortion), lens};
  cv::Matx33d turn;
  cv::Rodrigues(cv::Vec3d{0.01, -0.02, 0.015}, turn);
  std::copy_n(turn.val, 9, pair.cameras.right_from_left_rotation.begin());
  pair.cameras.right_from_left_translation_m = {-0.2998, 0.006, -0.009};
  pair.width_px = 321;
  pair.height_px = 239;
  return pair;
}

}  // namespace stereogrid::io::testing
