// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid::io {

/// Largest image that is read, far above any stereo camera's: what a few bytes declare must not fill the memory.
inline constexpr int largest_side_px{32768};
inline constexpr std::uint64_t most_pixels{largest_bytes::image / 8};

/// An interleaved 8-bit colour image: `pixels` is 3·width wide, R G B R G B …
struct RgbImage {
  int width{0};
  int height{0};
  Image<std::uint8_t> pixels;
};

/// An image as 8-bit grey, at its own scale.
struct ScaledImage {
  Image<std::uint8_t> grey;
  int bits{8};                       ///< sample_bits(): white is the largest number of this many bits
  bool has_other_byte_order{false};  ///< message whose is_bigendian is wrong
};

// All readers accept PNG, PGM/PPM, JPEG, TIFF and BMP, recognised by content. They throw InputError if the file is
// missing, truncated, damaged or of another format.

/// Reads an image as 8-bit grey; colour becomes luma. Sensors store 10, 12 or 14 bits in 16: `bits` (8 to
/// 16) is the number of used bits in 16-bit files, one scale for all frames of a drive. Brighter values saturate. 0:
/// sample_bits() of this image. 8-bit files are unchanged.
[[nodiscard]] STEREOGRID_EXPORT Image<std::uint8_t> read_grey(const std::filesystem::path& path, int bits = 0);

/// 8 for 8-bit samples; else the least of 10 … 16 bits that holds the image's brightest value. Throws InputError.
[[nodiscard]] STEREOGRID_EXPORT int sample_bits(const std::filesystem::path& path);
/// The same for an image in memory.
[[nodiscard]] STEREOGRID_EXPORT int sample_bits(const PixelView& image);

/// Reads an image at its own scale: nothing saturates.
[[nodiscard]] STEREOGRID_EXPORT ScaledImage read_scaled(const std::filesystem::path& path);

/// The same of a file's bytes; `name`: for error messages.
[[nodiscard]] STEREOGRID_EXPORT ScaledImage decode_scaled(const std::string& name, const std::string& bytes);

/// Reads a one-channel image without scaling; 8-bit values are widened. Throws InputError for colour.
[[nodiscard]] STEREOGRID_EXPORT Image<std::uint16_t> read_u16(const std::filesystem::path& path);

/// The same of a file's bytes; `name`: for error messages.
[[nodiscard]] STEREOGRID_EXPORT Image<std::uint16_t> decode_u16(const std::string& name, const std::string& bytes);

/// Reads an image as 8-bit colour; grey becomes R = G = B, 16 bits lose their lower half.
[[nodiscard]] STEREOGRID_EXPORT RgbImage read_rgb(const std::filesystem::path& path);

/// Writes a PNG: 8 or 16 bits of grey, or colour. Leaves whole files only (file.hpp). Throws DeviceError.
STEREOGRID_EXPORT void write_png(const std::filesystem::path& path, const Image<std::uint8_t>& grey);
STEREOGRID_EXPORT void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& grey);
STEREOGRID_EXPORT void write_png(const std::filesystem::path& path, const RgbImage& colour);

/// Bytes of a PNG.
[[nodiscard]] STEREOGRID_EXPORT std::string encode_png(const RgbImage& colour);

/// Bytes of a JPEG of 8-bit grey or bgr8. `quality`: 1 to 100.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::uint8_t> encode_jpeg(const PixelView& image, int quality);

/// Sets values that are not finite or not positive to 0 = none. Throws InputError where the values are not disparities
/// in px: nearly all are negative, most exceed the image's width, or none reaches 1 px. `name`: for the message.
STEREOGRID_EXPORT void settle_disparities(const std::string& name, Image<float>& image);

/// Reads a disparity image (px of the left image; values that are not finite or not positive become 0 = none),
/// recognised by content. Formats: PNG of 16 bits in KITTI's coding (disparity × 256), PFM of one channel, TIFF of 32-
/// or 64-bit floats, NumPy .npy of float32 or float64 in shape (height, width). Throws InputError: missing, truncated
/// or damaged, another type, or as settle_disparities().
[[nodiscard]] STEREOGRID_EXPORT Image<float> read_disparity(const std::filesystem::path& path);

/// Reads a depth image (along the camera's axis, m; values that are not finite or not positive become 0 = none): PNG or
/// TIFF of 16 bits, of which `units_per_m` are a metre; PFM, TIFF or .npy of floats in metres. Throws InputError as
/// read_disparity(), and where half of the values exceed 1000 m.
[[nodiscard]] STEREOGRID_EXPORT Image<float> read_depth(const std::filesystem::path& path, double units_per_m);

}  // namespace stereogrid::io
