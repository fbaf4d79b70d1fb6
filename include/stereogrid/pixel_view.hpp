// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// What the bytes of an image mean: the samples of a pixel in this order, 8 bits each; of grey16 one std::uint16_t.
enum class PixelFormat { grey8, grey16, bgr8, rgb8, bgra8, rgba8 };

/// 0: there is no such format.
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

/// An image as cameras and other libraries hold it. The memory stays theirs and need not be aligned.
struct PixelView {
  const void* data{nullptr};  ///< first pixel of the uppermost row
  int width_px{0};
  int height_px{0};
  std::ptrdiff_t stride_bytes{0};  ///< from a row to the one below it; below 0: stored upside down; 0: without gaps
  PixelFormat format{PixelFormat::grey8};
  int bits{16};  ///< of grey16: how many of a sample's lower bits carry the picture, 8 … 16; a sensor may have 10 or 12
};

/// Throws InputError: a size below 0, no data, rows that overlap or reach beyond any memory, no such format, `bits`
/// outside 8 … 16.
STEREOGRID_EXPORT void check(const PixelView& pixels);

/// Writes the pixels to `grey`, whose memory is used again where it has their size: nothing is allocated then. grey8 is
/// copied; of grey16 the upper 8 of its `bits` are taken, and brighter values saturate; colour becomes luma with the
/// weights and the rounding of OpenCV's cvtColor (0.299 R + 0.587 G + 0.114 B). Alpha is ignored.
///
/// Throws InputError as check(); `grey` is then as it was.
STEREOGRID_EXPORT void assign(Image<std::uint8_t>& grey, const PixelView& pixels);

}  // namespace stereogrid
