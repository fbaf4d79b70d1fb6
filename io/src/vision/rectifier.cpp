// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/rectifier.hpp"

#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/rectification.hpp"

namespace stereogrid::io {
namespace {

Image<std::uint8_t> remap(const Image<std::uint8_t>& raw, const cv::Mat& map, const cv::Mat& fractions) {
  const cv::Mat source{raw.height(), raw.width(), CV_8UC1, const_cast<std::uint8_t*>(raw.data())};
  Image<std::uint8_t> image{map.cols, map.rows};
  cv::Mat target{image.height(), image.width(), CV_8UC1, image.data()};
  cv::remap(source, target, map, fractions, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return image;
}

}  // namespace

struct Rectifier::Maps {
  Rig rig;
  cv::Mat left, left_fractions;
  cv::Mat right, right_fractions;
};

Rectifier::Rectifier(const RawPair& raw, int width_px, int height_px) {
  const Rectification to{rectify(raw, width_px, height_px)};
  Maps maps;
  maps.rig = to.rig;
  make_maps(raw.left, to.left_turn, to, maps.left, maps.left_fractions);
  make_maps(raw.right, to.right_turn, to, maps.right, maps.right_fractions);
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
