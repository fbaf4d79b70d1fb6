// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/rectifier.hpp"

#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/rectification.hpp"

namespace stereogrid::io {
namespace {

template <class T>
Image<T> remap(const Image<T>& raw, const cv::Mat& map, const cv::Mat& fractions, int interpolation) {
  const cv::Mat source{raw.height(), raw.width(), cv::DataType<T>::type, const_cast<T*>(raw.data())};
  Image<T> image{map.cols, map.rows};
  cv::Mat target{image.height(), image.width(), cv::DataType<T>::type, image.data()};
  cv::remap(source, target, map, fractions, interpolation, cv::BORDER_CONSTANT);
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
  return remap(raw, maps_->left, maps_->left_fractions, cv::INTER_LINEAR);
}

Image<float> Rectifier::left(const Image<float>& raw) const {
  return remap(raw, maps_->left, maps_->left_fractions, cv::INTER_NEAREST);
}

Image<std::uint8_t> Rectifier::right(const Image<std::uint8_t>& raw) const {
  return remap(raw, maps_->right, maps_->right_fractions, cv::INTER_LINEAR);
}

}  // namespace stereogrid::io
