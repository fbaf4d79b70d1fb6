// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/rectifier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "input/calibration/raw_pair.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"

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

Image<std::uint8_t> read_mask(const std::filesystem::path& path, int width_px, int height_px) {
  const std::string file{printable_path(path)};
  if (read_file(path, largest_bytes::image).starts_with("\xff\xd8")) {
    throw InputError{file, "is a JPEG, whose black is not quite 0.", "Save the mask as a PNG."};
  }
  const RgbImage image{read_rgb(path)};
  if (image.width != width_px || image.height != height_px) {
    throw InputError{file,
                     fmt::format("is a mask of {}×{} px, but the images have {}×{}.", image.width, image.height,
                                 width_px, height_px),
                     "A mask has the left image's size."};
  }
  Image<std::uint8_t> mask{width_px, height_px};
  for (std::size_t i{0}; i < mask.size(); ++i) {
    const std::uint8_t* const pixel{image.pixels.data() + 3 * i};
    mask.data()[i] = std::any_of(pixel, pixel + 3, [](std::uint8_t level) { return level != 0; }) ? 255 : 0;
  }
  if (std::ranges::none_of(mask, [](std::uint8_t pixel) { return pixel != 0; })) {
    throw InputError{file, "masks every pixel.", "Black (0) is what shows the vehicle; make the rest white."};
  }
  return mask;
}

Image<std::uint8_t> read_mask(const std::filesystem::path& path, const Calibration& calibration) {
  const Rig& rig{calibration.rig};
  Image<std::uint8_t> mask{read_mask(path, rig.width_px, rig.height_px)};
  if (!calibration.raw) return mask;
  mask = Rectifier{*calibration.raw, rig.width_px, rig.height_px}.left(mask);
  for (std::uint8_t& pixel : mask) pixel = pixel == 255 ? 255 : 0;
  return mask;
}

MaskUse use_of_mask(const std::filesystem::path& path, const Image<std::uint8_t>& mask) {
  const double share{static_cast<double>(std::ranges::count(mask, 0)) / static_cast<double>(mask.size())};
  const std::string text{
      fmt::format("mask: {}, {:.1f} % of the image are not used", printable_path(path), 100 * share)};
  if (share == 0) return {text + ": the vehicle is black in a mask, exactly 0, and this one has no such pixel.", true};
  if (share <= 0.5) return {text};
  return {text + ", the larger part. The vehicle is black (0) in a mask: is this one inverted?", true};
}

}  // namespace stereogrid::io
