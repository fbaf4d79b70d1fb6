// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string_view>

namespace stereogrid::io {

constexpr std::string_view png_signature{"\x89PNG\r\n\x1a\n", 8};

/// The first four bytes as a number.
[[nodiscard]] std::uint32_t big_endian(std::string_view bytes);

struct PngChunk {
  std::string_view whole;
  std::string_view covered;  ///< part that the checksum is of: type and content
  std::uint32_t checksum;

  [[nodiscard]] std::string_view type() const { return covered.substr(0, 4); }
  [[nodiscard]] std::string_view content() const { return covered.substr(4); }
};

/// Removes the first chunk from `bytes`, which follow the signature. Empty: they end within it.
[[nodiscard]] std::optional<PngChunk> take_png_chunk(std::string_view& bytes);

/// Decodes a PNG that has passed `checked_image_bytes` with libdeflate, which is faster than libpng: 8 or 16 bits, grey
/// or colour (as B G R), not interlaced. Empty: another kind, or damaged data.
[[nodiscard]] cv::Mat decode_plain_png(std::string_view bytes);

}  // namespace stereogrid::io
