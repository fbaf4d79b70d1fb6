// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/raw_pair.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

// tan 60°: beyond, a pixel is stretched to more than four times its width
constexpr double widest_tangent{1.7320508075688772};

cv::Matx33d matrix_of(const CameraModel& camera) {
  return {camera.focal_u_px, 0, camera.cx_px, 0, camera.focal_v_px, camera.cy_px, 0, 0, 1};
}

/// cv::fisheye requires four numbers.
std::vector<double> fisheye_distortion_of(const CameraModel& camera) {
  return camera.distortion.empty() ? std::vector<double>(4) : camera.distortion;
}

void check(const RawPair& raw) {
  const auto& t{raw.right_from_left_translation_m};
  if (raw.left.lens != raw.right.lens) throw InputError{"One camera has a fisheye lens, the other has not."};
  if (t[0] == 0 && t[1] == 0 && t[2] == 0) {
    throw InputError{"The baseline is zero: the two cameras are the same one."};
  }
  if (t[0] > 0 && t[0] > std::abs(t[1]) && t[0] > std::abs(t[2])) {
    throw InputError{
        "The baseline is negative (the translation from left to right points to +x): left and right are swapped, or "
        "the transform is the inverse of the expected one."};
  }
  if (std::abs(t[0]) < std::abs(t[1]) || std::abs(t[0]) < std::abs(t[2])) {
    throw InputError{"The cameras do not stand side by side: the translation is not mainly along x."};
  }
}

void take_projection(Rectification& to, const cv::Mat& left, const cv::Mat& right) {
  const cv::Matx34d p{left};
  const cv::Matx34d q{right};
  to.camera = p.get_minor<3, 3>(0, 0);
  to.rig.baseline_m = -q(0, 3) / q(0, 0);
}

void rectify_perspective(const RawPair& raw, cv::Size size, Rectification& to) {
  cv::Mat left, right, depth;
  cv::stereoRectify(matrix_of(raw.left), raw.left.distortion, matrix_of(raw.right), raw.right.distortion, size,
                    cv::Matx33d{raw.right_from_left_rotation.data()},
                    cv::Vec3d{raw.right_from_left_translation_m.data()}, to.left_turn, to.right_turn, left, right,
                    depth, cv::CALIB_ZERO_DISPARITY, 0, size);
  take_projection(to, left, right);
}

void rectify_fisheye(const RawPair& raw, cv::Size size, Rectification& to) {
  const cv::Vec3d translation{raw.right_from_left_translation_m.data()};
  cv::Mat left, right, depth;
  cv::fisheye::stereoRectify(matrix_of(raw.left), fisheye_distortion_of(raw.left), matrix_of(raw.right),
                             fisheye_distortion_of(raw.right), size, cv::Matx33d{raw.right_from_left_rotation.data()},
                             translation, to.left_turn, to.right_turn, left, right, depth, cv::CALIB_ZERO_DISPARITY,
                             size);
  take_projection(to, left, right);
  to.rig.baseline_m = cv::norm(translation);
  // a flat image cannot show angles beyond 90° from the axis: OpenCV's focal length is meaningless then
  const double least_focal_px{size.width / (2 * widest_tangent)};
  if (to.camera(0, 0) >= least_focal_px) return;
  to.camera = {least_focal_px, 0, (size.width - 1) / 2.0, 0, least_focal_px, (size.height - 1) / 2.0, 0, 0, 1};
}

bool is_alike(double a, double b) {
  constexpr double alike_px{0.01};
  return std::abs(a - b) <= alike_px;
}

void keep_left_camera(const RawPair& raw, Rectification& to) {
  to.left_turn = to.right_turn = cv::Mat{cv::Matx33d::eye()};
  to.camera = matrix_of(raw.left);
  to.rig.baseline_m = -raw.right_from_left_translation_m[0];
}

}  // namespace

bool is_row_aligned(const RawPair& raw) {
  const auto is_plain{[](const CameraModel& camera) {
    return camera.lens == LensModel::perspective && is_alike(camera.focal_u_px, camera.focal_v_px) &&
           std::ranges::all_of(camera.distortion, [](double number) { return number == 0; });
  }};
  const bool are_equal{is_alike(raw.left.focal_u_px, raw.right.focal_u_px) &&
                       is_alike(raw.left.cy_px, raw.right.cy_px)};
  constexpr double turn_max{1e-6};
  const cv::Matx33d turn{raw.right_from_left_rotation.data()};
  const auto& t{raw.right_from_left_translation_m};
  return is_plain(raw.left) && is_plain(raw.right) && are_equal &&
         cv::norm(turn - cv::Matx33d::eye(), cv::NORM_INF) < turn_max && std::hypot(t[1], t[2]) < turn_max * -t[0];
}

Rectification rectify(const RawPair& raw, int width_px, int height_px) {
  check(raw);
  Rectification to;
  const cv::Size size{width_px, height_px};
  if (is_row_aligned(raw)) {
    keep_left_camera(raw, to);
  } else if (raw.left.lens == LensModel::fisheye) {
    rectify_fisheye(raw, size, to);
  } else {
    rectify_perspective(raw, size, to);
  }
  to.rig.width_px = width_px;
  to.rig.height_px = height_px;
  to.rig.focal_px = to.camera(0, 0);
  to.rig.cx_px = to.camera(0, 2);
  to.rig.cy_px = to.camera(1, 2);
  if (!(to.rig.focal_px > 0)) throw InputError{"The pair cannot be rectified: the calibration contradicts itself."};
  return to;
}

void make_maps(const CameraModel& raw, const cv::Mat& turn, const Rectification& to, cv::Mat& map, cv::Mat& fractions) {
  const cv::Size size{to.rig.width_px, to.rig.height_px};
  if (raw.lens == LensModel::fisheye) {
    cv::fisheye::initUndistortRectifyMap(matrix_of(raw), fisheye_distortion_of(raw), turn, to.camera, size, CV_16SC2,
                                         map, fractions);
  } else {
    cv::initUndistortRectifyMap(matrix_of(raw), raw.distortion, turn, to.camera, size, CV_16SC2, map, fractions);
  }
}

}  // namespace stereogrid::io
