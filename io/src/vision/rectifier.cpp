// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/rectifier.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

cv::Matx33d matrix_of(const CameraModel& camera) {
  return {camera.focal_u_px, 0, camera.centre_u_px, 0, camera.focal_v_px, camera.centre_v_px, 0, 0, 1};
}

Image<std::uint8_t> remap(const Image<std::uint8_t>& raw, const cv::Mat& map, const cv::Mat& fractions) {
  const cv::Mat source{raw.height(), raw.width(), CV_8UC1, const_cast<std::uint8_t*>(raw.data())};
  Image<std::uint8_t> image{map.cols, map.rows};
  cv::Mat target{image.height(), image.width(), CV_8UC1, image.data()};
  cv::remap(source, target, map, fractions, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return image;
}

void check_baseline(const RawPair& raw) {
  const auto& t{raw.right_from_left_translation_m};
  if (t[0] == 0 && t[1] == 0 && t[2] == 0) {
    throw InputError{"The baseline is zero: the two cameras are the same one."};
  }
  if (t[0] > 0 && t[0] > std::abs(t[1]) && t[0] > std::abs(t[2])) {
    throw InputError{"The baseline is negative (translation_m points to +x): left and right are swapped."};
  }
  if (std::abs(t[0]) < std::abs(t[1]) || std::abs(t[0]) < std::abs(t[2])) {
    throw InputError{"The cameras do not stand side by side: translation_m is not mainly along x."};
  }
}

}  // namespace

struct Rectifier::Maps {
  Rig rig;
  cv::Mat left, left_fractions;
  cv::Mat right, right_fractions;
};

Rectifier::Rectifier(const RawPair& raw, int width_px, int height_px) {
  check_baseline(raw);
  const cv::Size size{width_px, height_px};
  const cv::Matx33d rotation{raw.right_from_left_rotation.data()};
  const cv::Vec3d translation{raw.right_from_left_translation_m.data()};
  const cv::Matx33d left{matrix_of(raw.left)};
  const cv::Matx33d right{matrix_of(raw.right)};
  cv::Mat left_turn, right_turn, left_projection, right_projection, depth;
  cv::stereoRectify(left, raw.left.distortion, right, raw.right.distortion, size, rotation, translation, left_turn,
                    right_turn, left_projection, right_projection, depth, cv::CALIB_ZERO_DISPARITY, 0, size);
  Maps maps;
  cv::initUndistortRectifyMap(left, raw.left.distortion, left_turn, left_projection, size, CV_16SC2, maps.left,
                              maps.left_fractions);
  cv::initUndistortRectifyMap(right, raw.right.distortion, right_turn, right_projection, size, CV_16SC2, maps.right,
                              maps.right_fractions);
  const cv::Matx34d p{left_projection};
  const cv::Matx34d q{right_projection};
  maps.rig.width_px = width_px;
  maps.rig.height_px = height_px;
  maps.rig.focal_px = p(0, 0);
  maps.rig.centre_u_px = p(0, 2);
  maps.rig.centre_v_px = p(1, 2);
  maps.rig.baseline_m = -q(0, 3) / q(0, 0);
  if (!(maps.rig.focal_px > 0)) throw InputError{"The pair cannot be rectified: the calibration contradicts itself."};
  maps_ = std::make_unique<const Maps>(std::move(maps));
}

Rectifier::Rectifier(Rectifier&&) noexcept = default;
Rectifier& Rectifier::operator=(Rectifier&&) noexcept = default;
Rectifier::~Rectifier() = default;

const Rig& Rectifier::rig() const {
  return maps_->rig;
}

Image<std::uint8_t> Rectifier::left(const Image<std::uint8_t>& raw) const {
  return remap(raw, maps_->left, maps_->left_fractions);
}

Image<std::uint8_t> Rectifier::right(const Image<std::uint8_t>& raw) const {
  return remap(raw, maps_->right, maps_->right_fractions);
}

}  // namespace stereogrid::io
