// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "files/formats.hpp"

#include <fmt/format.h>
#include <webp/decode.h>

#include <algorithm>
#include <cstdint>

#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::io {

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
  throw InputError{file, "is no image of a kind that can be read (allowed: PNG, PGM, PPM, JPEG, TIFF, WebP, BMP).",
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
