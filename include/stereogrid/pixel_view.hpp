// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Layout of an image's bytes: the samples of a pixel in this order, 8 bits each; grey16: one std::uint16_t.
enum class PixelFormat { grey8, grey16, bgr8, rgb8, bgra8, rgba8 };

/// Bytes of a pixel; 0: unknown format.
[[nodiscard]] constexpr int bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::grey8:
      return 1;
    case PixelFormat::grey16:
      return 2;
    case PixelFormat::bgr8:
    case PixelFormat::rgb8:
      return 3;
    case PixelFormat::bgra8:
    case PixelFormat::rgba8:
      return 4;
  }
  return 0;
}

/// View of an image of a camera or another library. The memory stays foreign and need not be aligned.
struct PixelView {
  const void* data{nullptr};  ///< first pixel of the uppermost row
  int width_px{0};
  int height_px{0};
  std::ptrdiff_t stride_bytes{0};  ///< distance between rows; negative: stored upside down; 0: contiguous
  PixelFormat format{PixelFormat::grey8};
  int bits{16};  ///< grey16: number of used lower bits of a sample, 8 … 16; sensors have 10 or 12
};

/// Throws InputError: a negative size, no data, rows that overlap or exceed any memory, unknown format, `bits` outside
/// 8 … 16.
STEREOGRID_EXPORT void check(const PixelView& pixels);

/// Writes the pixels to `grey`, whose memory is reused if the size is equal. grey8 is copied. grey16: the upper 8 of
/// its `bits`, brighter values saturate. Colour: luma with the weights and rounding of OpenCV's cvtColor (0.299 R +
/// 0.587 G + 0.114 B). Alpha is ignored.
///
/// Throws InputError as check(); `grey` is then unchanged.
STEREOGRID_EXPORT void assign(Image<std::uint8_t>& grey, const PixelView& pixels);

}  // namespace stereogrid
