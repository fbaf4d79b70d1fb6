// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <webp/decode.h>

#include <cstdint>

#include "files/decode_image.hpp"

namespace stereogrid::io {

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
