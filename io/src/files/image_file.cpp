// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/image_file.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include <fmt/format.h>
#include <webp/decode.h>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::io {
namespace {

/// 8- or 16-bit unsigned, one or three channels (B G R).
cv::Mat decode(const std::string& name, std::string_view bytes) {
  cv::Mat image{decode_image(name, bytes)};
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    throw InputError{name, "has neither 8 nor 16 bits a sample.", "Convert it to an 8-bit PNG."};
  }
  return image;
}

cv::Mat decode(const std::filesystem::path& path) {
  return decode(printable_path(path), read_file(path, largest_bytes::image));
}

cv::Mat grey_of(cv::Mat image) {
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  return image;
}

template <class T>
Image<T> copy_of(const cv::Mat& mat) {
  Image<T> image{mat.cols * mat.channels(), mat.rows};
  for (int v{0}; v < mat.rows; ++v) std::copy_n(mat.ptr<T>(v), image.width(), image.row(v));
  return image;
}

ScaledImage scaled(const cv::Mat& grey, int bits = 0) {
  ScaledImage image{{}, bits == 0 ? sample_bits(view_of(grey)) : bits};
  assign(image.grey, view_of(grey, image.bits));
  return image;
}

template <class T>
cv::Mat mat_of(const Image<T>& image, int channels) {
  return {image.height(), image.width() / channels, CV_MAKETYPE(cv::DataType<T>::depth, channels),
          const_cast<T*>(image.data())};
}

}  // namespace

Image<std::uint8_t> read_grey(const std::filesystem::path& path, int bits) {
  return scaled(grey_of(decode(path)), bits).grey;
}

int sample_bits(const std::filesystem::path& path) {
  return sample_bits(view_of(grey_of(decode(path))));
}

int sample_bits(const PixelView& image) {
  PixelView any_bits{image};
  any_bits.bits = 16;
  check(any_bits);
  if (image.format != PixelFormat::grey16 || image.data == nullptr) return 8;
  const auto* const first{static_cast<const std::byte*>(image.data)};
  const auto width{static_cast<std::size_t>(image.width_px)};
  const std::ptrdiff_t stride{image.stride_bytes == 0 ? 2 * std::ptrdiff_t{image.width_px} : image.stride_bytes};
  std::vector<std::uint16_t> row(width);
  std::uint16_t brightest{0};
  for (int v{0}; v < image.height_px && width > 0; ++v) {
    std::memcpy(row.data(), first + v * stride, 2 * width);  // the memory need not be aligned
    brightest = std::max(brightest, *std::ranges::max_element(row));
  }
  return std::clamp(static_cast<int>(std::bit_width(brightest)), 10, 16);
}

ScaledImage read_scaled(const std::filesystem::path& path) {
  return scaled(grey_of(decode(path)));
}

ScaledImage decode_scaled(const std::string& name, const std::string& bytes) {
  return scaled(grey_of(decode(name, bytes)));
}

Image<std::uint16_t> read_u16(const std::filesystem::path& path) {
  return decode_u16(printable_path(path), read_file(path, largest_bytes::image));
}

Image<std::uint16_t> decode_u16(const std::string& name, const std::string& bytes) {
  cv::Mat image{decode(name, bytes)};
  if (image.channels() != 1) throw InputError{name, "is in colour.", "An image of one channel is needed."};
  image.convertTo(image, CV_16U);
  return copy_of<std::uint16_t>(image);
}

RgbImage read_rgb(const std::filesystem::path& path) {
  cv::Mat image{decode(path)};
  cv::cvtColor(image, image, image.channels() == 1 ? cv::COLOR_GRAY2RGB : cv::COLOR_BGR2RGB);
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / 256, -0.5 + 1.0 / 512);
  return {image.cols, image.rows, copy_of<std::uint8_t>(image)};
}

void write_png(const std::filesystem::path& path, const Image<std::uint8_t>& grey) {
  write_file(path, encode_png(mat_of(grey, 1)));
}

void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& grey) {
  write_file(path, encode_png(mat_of(grey, 1)));
}

std::string encode_png(const RgbImage& colour) {
  cv::Mat swapped;
  cv::cvtColor(mat_of(colour.pixels, 3), swapped, cv::COLOR_RGB2BGR);
  return encode_png(swapped);
}

void write_png(const std::filesystem::path& path, const RgbImage& colour) {
  write_file(path, encode_png(colour));
}

void fail_damaged(const std::string& file, const std::string& what) {
  throw InputError{file, what, "Copy or record it again."};
}

void fail_unsupported(const std::string& file, const std::string& what) {
  throw InputError{file, what, "Convert it to PNG."};
}

void check_size(const std::string& file, std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0) fail_damaged(file, "has no pixels.");
  if (std::max(width, height) <= largest_side_px && width * height <= most_pixels) return;
  throw InputError{file, fmt::format("says that it has {} × {} px.", width, height),
                   fmt::format("Images of up to {} px a side and {} million pixels can be read.", largest_side_px,
                               most_pixels / 1'000'000)};
}

cv::Mat decode_image(const std::string& file, std::string_view bytes) {
  if (bytes.empty()) fail_damaged(file, "is empty.");
  if (bytes.starts_with(png_signature)) return decode_png(file, bytes);
  if (bytes.starts_with(png_signature.substr(0, bytes.size()))) fail_damaged(file, "is a truncated PNG.");
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(file, bytes);
  if (bytes.size() > 2 && bytes[0] == 'P' && std::string_view{"2356"}.find(bytes[1]) != std::string_view::npos) {
    return decode_pnm(file, bytes);
  }
  if (bytes.starts_with("II") || bytes.starts_with("MM")) return decode_tiff(file, bytes);
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return decode_webp(file, bytes);
  if (bytes.starts_with("BM")) return decode_bmp(file, bytes);
  throw InputError{file, "is not an image of a kind that can be read (allowed: PNG, PGM, PPM, JPEG, TIFF, WebP, BMP).",
                   "Convert it to PNG."};
}

cv::Mat decode_webp(const std::string& file, std::string_view bytes) {
  const auto* const data{reinterpret_cast<const std::uint8_t*>(bytes.data())};
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK) fail_damaged(file);
  if (features.has_animation != 0) fail_unsupported(file, "is an animated WebP.");
  check_size(file, static_cast<std::uint64_t>(features.width), static_cast<std::uint64_t>(features.height));
  cv::Mat image(features.height, features.width, CV_8UC3);
  const auto stride{static_cast<int>(image.step)};
  if (WebPDecodeBGRInto(data, bytes.size(), image.data, image.step * static_cast<std::size_t>(image.rows), stride) ==
      nullptr) {
    fail_damaged(file);
  }
  return image;
}

}  // namespace stereogrid::io
