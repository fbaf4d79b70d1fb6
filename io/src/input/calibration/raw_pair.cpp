// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/raw_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "stereogrid/error.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

void check_distortion(const CameraModel& camera, const Origin& origin) {
  constexpr std::array<std::size_t, 6> perspective{0, 4, 5, 8, 12, 14};
  const std::size_t count{camera.distortion.size()};
  if (camera.lens == LensModel::fisheye) {
    if (count == 0 || count == 4) return;
    origin.fail(fmt::format("has {} distortion numbers; a fisheye lens has 4 (k1 k2 k3 k4).", count));
  }
  if (std::ranges::count(perspective, count) == 0) {
    origin.fail(
        fmt::format("has {} distortion numbers; there are 0, 4, 5, 8, 12 or 14 (k1 k2 p1 p2 k3 k4 k5 k6 …).", count));
  }
}

/// Cameras that see what a rectified pair sees: turning and bending them would change nothing.
bool is_rectified(const RawPair& raw) {
  constexpr double alike_px{0.01};
  return is_row_aligned(raw) && std::abs(raw.left.cx_px - raw.right.cx_px) <= alike_px;
}

}  // namespace

void check_camera(const CameraModel& camera, const Origin& origin) {
  if (camera.focal_u_px <= 0 || camera.focal_v_px <= 0) origin.fail("has a focal length that is not positive.");
  if (camera.focal_u_px < 1 || camera.focal_v_px < 1) origin.fail("has a focal length below one pixel.");
  if (std::abs(camera.focal_u_px - camera.focal_v_px) > 0.2 * camera.focal_u_px) {
    origin.fail("has focal lengths along u and v that differ by more than a fifth.");
  }
  check_distortion(camera, origin);
}

CameraModel camera_of(const std::vector<double>& k, const Origin& origin, const char* key) {
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    origin.fail(fmt::format("'{}' is not a camera matrix.", key), "It is fx 0 cx, 0 fy cy, 0 0 1, in pixels.");
  }
  return {k[0], k[4], k[2], k[5], {}};
}

cv::Matx33d rotation_of(const std::vector<double>& numbers, const Origin& origin, const char* key) {
  cv::Matx33d rotation;
  if (numbers.size() == 3) {
    cv::Rodrigues(cv::Vec3d{numbers[0], numbers[1], numbers[2]}, rotation);
  } else if (numbers.size() == 9) {
    rotation = cv::Matx33d{numbers.data()};
  } else {
    origin.fail(fmt::format("has in '{}' a rotation of {} numbers; there are 3 (Rodrigues) or 9 (matrix).", key,
                            numbers.size()));
  }
  const double off{cv::norm(rotation * rotation.t() - cv::Matx33d::eye(), cv::NORM_INF)};
  if (off > 0.01 || cv::determinant(rotation) < 0) {
    origin.fail(fmt::format("has in '{}' a rotation that is not a rotation matrix.", key));
  }
  return rotation;
}

void set_transform(RawPair& raw, const cv::Matx33d& rotation, const cv::Vec3d& translation_m) {
  std::copy_n(rotation.val, 9, raw.right_from_left_rotation.begin());
  std::copy_n(translation_m.val, 3, raw.right_from_left_translation_m.begin());
}

void take_row_aligned(Calibration& calibration, const Rig& optics, double right_cx_px) {
  constexpr double alike_px{0.01};
  Rig& rig{calibration.rig};
  rig.focal_px = optics.focal_px;
  rig.cx_px = optics.cx_px;
  rig.cy_px = optics.cy_px;
  rig.baseline_m = optics.baseline_m;
  if (std::abs(right_cx_px - rig.cx_px) <= alike_px) return;
  RawPair& raw{calibration.raw.emplace()};
  raw.left = {rig.focal_px, rig.focal_px, rig.cx_px, rig.cy_px, {}};
  raw.right = {rig.focal_px, rig.focal_px, right_cx_px, rig.cy_px, {}};
  raw.right_from_left_translation_m = {-rig.baseline_m, 0, 0};
  calibration.notes.push_back(fmt::format(
      "centres: cx is {:.6g} px in the left image and {:.6g} px in the right one: the right image is shifted",
      rig.cx_px, right_cx_px));
}

void take_unit(Calibration& calibration, const Origin& origin, const CalibrationRequest& request) {
  constexpr double shortest_m{1e-3};
  constexpr double longest_m{5};
  const cv::Vec3d t{calibration.raw ? cv::Vec3d{calibration.raw->right_from_left_translation_m.data()}
                                    : cv::Vec3d{-calibration.rig.baseline_m, 0, 0}};
  const double length{cv::norm(t)};
  if (request.baseline_m && length > 0) {
    if (calibration.raw) {
      set_transform(*calibration.raw, cv::Matx33d{calibration.raw->right_from_left_rotation.data()},
                    t * (*request.baseline_m / length));
    }
    calibration.rig.baseline_m = *request.baseline_m;
    return;
  }
  if (length == 0 || (length >= shortest_m && length <= longest_m)) return;
  constexpr double longest_cm{100};
  const std::string unit{
      length > longest_cm  ? fmt::format("millimetres ({:.4g} m) or squares of the target", length / 1000)
      : length > longest_m ? fmt::format("centimetres ({:.4g} m), millimetres ({:.4g} m) or squares of the target",
                                         length / 100, length / 1000)
                           : "kilometres or a slip"};
  origin.fail(fmt::format("puts the cameras {:.4g} m apart, which looks like {}.", length, unit),
              fmt::format("Measure the distance of the lenses, and name this file in a calibration.yaml: 'from: FILE' "
                          "and 'baseline_m: {:.4g}', or what it is.",
                          length > longest_m && length < 5000 ? length / 1000 : 0.12));
}

void take_rig_of_raw(Calibration& calibration, const Origin& origin, const CalibrationRequest& request) {
  Rig& rig{calibration.rig};
  const RawPair& raw{*calibration.raw};
  fit_size(calibration, origin, request);
  if (is_rectified(raw)) {
    rig.focal_px = raw.left.focal_u_px;
    rig.cx_px = raw.left.cx_px;
    rig.cy_px = raw.left.cy_px;
    rig.baseline_m = -raw.right_from_left_translation_m[0];
    calibration.raw.reset();
    return;
  }
  if (rig.width_px == 0 && !is_row_aligned(raw)) origin.fail("has no 'image' size, which a raw pair needs.");
  try {
    const Rig rectified{rectify(raw, rig.width_px, rig.height_px).rig};
    rig.focal_px = rectified.focal_px;
    rig.cx_px = rectified.cx_px;
    rig.cy_px = rectified.cy_px;
    rig.baseline_m = rectified.baseline_m;
  } catch (const InputError& error) {
    origin.fail(error.what());
  } catch (const cv::Exception&) {  // numbers that contradict each other in ways that are not foreseen here
    origin.fail("holds a raw pair that cannot be rectified.");
  }
}

void take_pair(Calibration& calibration, const CameraModel& left, const CameraModel& right,
               const cv::Matx44d& right_from_left, const Origin& origin, const CalibrationRequest& request) {
  check_camera(left, origin);
  check_camera(right, origin);
  RawPair& raw{calibration.raw.emplace()};
  raw.left = left;
  raw.right = right;
  set_transform(raw, right_from_left.get_minor<3, 3>(0, 0),
                {right_from_left(0, 3), right_from_left(1, 3), right_from_left(2, 3)});
  take_unit(calibration, origin, request);
  take_rig_of_raw(calibration, origin, request);
}

namespace {

/// Camera of the image turned by 180°.
CameraModel turned(CameraModel camera, const Rig& size) {
  camera.cx_px = size.width_px - 1 - camera.cx_px;
  camera.cy_px = size.height_px - 1 - camera.cy_px;
  if (camera.lens == LensModel::fisheye) return camera;
  for (const std::size_t odd : {2U, 3U, 8U, 9U, 10U, 11U, 12U, 13U}) {  // p1 p2, s1 to s4, τx τy
    if (odd < camera.distortion.size()) camera.distortion[odd] = -camera.distortion[odd];
  }
  return camera;
}

}  // namespace

void turn_upside_down(Calibration& calibration, const Origin& origin) {
  Rig& rig{calibration.rig};
  rig.cx_px = rig.width_px - 1 - rig.cx_px;
  rig.cy_px = rig.height_px - 1 - rig.cy_px;
  if (!calibration.raw) return;
  const RawPair raw{*calibration.raw};
  calibration.raw->left = turned(raw.right, rig);
  calibration.raw->right = turned(raw.left, rig);
  const cv::Matx33d about_axis{-1, 0, 0, 0, -1, 0, 0, 0, 1};
  const cv::Matx33d back{cv::Matx33d{raw.right_from_left_rotation.data()}.t()};
  set_transform(*calibration.raw, about_axis * back * about_axis,
                about_axis * back * -cv::Vec3d{raw.right_from_left_translation_m.data()});
  take_rig_of_raw(calibration, origin, {rig.width_px, rig.height_px});
}

cv::Matx44d rigid_of(const std::vector<double>& numbers, const Origin& origin, const char* key) {
  std::vector<double> all{numbers};
  if (all.size() == 12) all.insert(all.end(), {0, 0, 0, 1});
  const char* const form{"It is 4 rows of 4: a rotation, the translation in the last column, and 0 0 0 1."};
  if (all.size() != 16) origin.fail(fmt::format("has a '{}' of {} numbers, not 16.", key, all.size()), form);
  const cv::Matx44d transform{all.data()};
  const auto is_end{[](double a, double b, double c, double d) { return a == 0 && b == 0 && c == 0 && d == 1; }};
  if (!is_end(transform(3, 0), transform(3, 1), transform(3, 2), transform(3, 3))) {
    const bool is_transposed{is_end(transform(0, 3), transform(1, 3), transform(2, 3), transform(3, 3))};
    origin.fail(fmt::format("has a '{}' that is {}.", key, is_transposed ? "transposed" : "no rigid transform"), form);
  }
  const cv::Matx33d turn{transform.get_minor<3, 3>(0, 0)};
  static_cast<void>(rotation_of({turn.val, turn.val + 9}, origin, key));
  return transform;
}

cv::Matx44d rigid_of(const std::array<double, 4>& quaternion, const cv::Vec3d& translation, const Origin& origin,
                     const char* key) {
  const auto unit{unit_quaternion(quaternion)};
  if (!unit) origin.fail(fmt::format("has in '{}' a quaternion whose length is not 1.", key), see_documentation);
  const auto& [x, y, z, w]{*unit};
  return rigid_of(cv::Matx33d{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
                              1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w),
                              1 - 2 * (x * x + y * y)},
                  translation);
}

cv::Matx44d rigid_of(const cv::Matx33d& r, const cv::Vec3d& t) {
  return {r(0, 0), r(0, 1), r(0, 2), t[0], r(1, 0), r(1, 1), r(1, 2), t[1],
          r(2, 0), r(2, 1), r(2, 2), t[2], 0,       0,       0,       1};
}

cv::Matx44d inverse(const cv::Matx44d& rigid) {
  const cv::Matx33d turn{rigid.get_minor<3, 3>(0, 0).t()};
  return rigid_of(turn, turn * cv::Vec3d{-rigid(0, 3), -rigid(1, 3), -rigid(2, 3)});
}

}  // namespace stereogrid::io
