// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>

#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/ros_image.hpp"

namespace stereogrid::io {

/// Decodes a PNG, JPEG, PNM, BMP, WebP or TIFF, recognised by its first bytes, into 8 or 16 bits of one or three
/// channels (B G R); a TIFF may have one channel of 32- or 64-bit floats. Alpha is left out. Throws InputError(file,
/// …): another format, truncated, damaged, or too many pixels.
[[nodiscard]] cv::Mat decode_image(const std::string& file, std::string_view bytes);

// One format each; the first bytes have been checked.
[[nodiscard]] cv::Mat decode_png(const std::string& file, std::string_view bytes);
[[nodiscard]] cv::Mat decode_jpeg(const std::string& file, std::string_view bytes);
[[nodiscard]] cv::Mat decode_pnm(const std::string& file, std::string_view bytes);
[[nodiscard]] cv::Mat decode_bmp(const std::string& file, std::string_view bytes);
[[nodiscard]] cv::Mat decode_tiff(const std::string& file, std::string_view bytes);
[[nodiscard]] cv::Mat decode_webp(const std::string& file, std::string_view bytes);

/// Throws InputError: an image of this size has no pixels, or too many.
void check_size(const std::string& file, std::uint64_t width, std::uint64_t height);

[[noreturn]] void fail_damaged(const std::string& file, const std::string& what = "cannot be decoded, it is damaged.");
/// For kinds within a format that no camera records.
[[noreturn]] void fail_unsupported(const std::string& file, const std::string& what);

constexpr std::string_view png_signature{"\x89PNG\r\n\x1a\n", 8};

/// `image`: 8 or 16 bits of one or three channels (B G R).
[[nodiscard]] std::string encode_png(const cv::Mat& image);

/// Pixels in the machine's byte order: of the message, or swapped copies. Corrects `is_bigendian` of 16-bit samples
/// where the other order is much smoother. Throws InputError where the message is smaller than it says.
[[nodiscard]] cv::Mat ros_pixels(RosImage& image, int type, const std::string& name);

/// Fills `bytes`; false if `packed` is no zlib stream, is damaged, or holds less or more.
bool inflate_zlib(std::string_view packed, std::span<std::uint8_t> bytes);

/// CRC-32 of zip and PNG.
std::uint32_t crc32_of(std::string_view bytes);

struct DTypeEntry {
  DType dtype;
  std::string_view spelling;
  std::size_t size;
};

constexpr std::array<DTypeEntry, 12> dtypes{{{DType::float16, "<f2", 2},
                                             {DType::float32, "<f4", 4},
                                             {DType::float64, "<f8", 8},
                                             {DType::int8, "|i1", 1},
                                             {DType::int16, "<i2", 2},
                                             {DType::int32, "<i4", 4},
                                             {DType::int64, "<i8", 8},
                                             {DType::uint8, "|u1", 1},
                                             {DType::uint16, "<u2", 2},
                                             {DType::uint32, "<u4", 4},
                                             {DType::uint64, "<u8", 8},
                                             {DType::boolean, "|b1", 1}}};

}  // namespace stereogrid::io
