// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pixel_view.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "stereogrid/error.hpp"

namespace stereogrid {

void check(const PixelView& pixels) {
  const auto require = [](bool fine, const char* problem, const char* remedy) {
    if (!fine) throw InputError{"image", problem, remedy};
  };
  require(bytes_per_pixel(pixels.format) > 0, "has a format that there is not.", "Take one of PixelFormat.");
  require(pixels.width_px >= 0 && pixels.height_px >= 0, "has a size below 0.", "Check its width and height.");
  require(pixels.data != nullptr || pixels.width_px == 0 || pixels.height_px == 0, "has a size, but no pixels.",
          "Give the address of its first one.");
  const std::ptrdiff_t row_bytes{std::ptrdiff_t{bytes_per_pixel(pixels.format)} * pixels.width_px};
  const std::ptrdiff_t stride{pixels.stride_bytes};
  require(stride == 0 || stride >= row_bytes || stride <= -row_bytes, "has rows that overlap.",
          "The stride counts bytes and must be a row's at least.");
  const std::ptrdiff_t stride_max{std::numeric_limits<std::ptrdiff_t>::max() / (std::ptrdiff_t{pixels.height_px} + 1)};
  require(stride <= stride_max && stride >= -stride_max, "has more rows than memory has room for.",
          "Check its height and stride.");
  require(pixels.format != PixelFormat::grey16 || (pixels.bits >= 8 && pixels.bits <= 16),
          "cannot have that many bits.", "Use 8 … 16 bits with grey16.");
}

namespace {

// Luma in 1/2¹⁵, as OpenCV has it.
constexpr int red_weight{9798};
constexpr int green_weight{19235};
constexpr int blue_weight{3735};
constexpr int weight_bits{15};

void from_16_bits(const unsigned char* from, int width, int bits, std::uint8_t* to) {
  const int shift{bits - 8};
  for (int u{0}; u < width; ++u) {
    std::uint16_t sample{};
    std::memcpy(&sample, from + 2 * static_cast<std::ptrdiff_t>(u), sizeof sample);
    to[u] = static_cast<std::uint8_t>(std::min(sample >> shift, 255));
  }
}

// Red first, or last.
template <int bytes, bool is_red_first>
void from_colour(const unsigned char* from, int width, std::uint8_t* to) {
  constexpr int first_weight{is_red_first ? red_weight : blue_weight};
  constexpr int third_weight{is_red_first ? blue_weight : red_weight};
  for (int u{0}; u < width; ++u, from += bytes) {
    const int sum{first_weight * from[0] + green_weight * from[1] + third_weight * from[2]};
    to[u] = static_cast<std::uint8_t>((sum + (1 << (weight_bits - 1))) >> weight_bits);
  }
}

void convert_row(const PixelView& pixels, const unsigned char* from, std::uint8_t* to) {
  switch (pixels.format) {
    case PixelFormat::grey8:
      std::copy_n(from, pixels.width_px, to);
      return;
    case PixelFormat::grey16:
      return from_16_bits(from, pixels.width_px, pixels.bits, to);
    case PixelFormat::bgr8:
      return from_colour<3, false>(from, pixels.width_px, to);
    case PixelFormat::rgb8:
      return from_colour<3, true>(from, pixels.width_px, to);
    case PixelFormat::bgra8:
      return from_colour<4, false>(from, pixels.width_px, to);
    case PixelFormat::rgba8:
      return from_colour<4, true>(from, pixels.width_px, to);
  }
}

}  // namespace

void assign(Image<std::uint8_t>& grey, const PixelView& pixels) {
  check(pixels);
  if (grey.width() != pixels.width_px || grey.height() != pixels.height_px) {
    grey = Image<std::uint8_t>{pixels.width_px, pixels.height_px};
  }
  if (grey.empty()) return;
  const std::ptrdiff_t row_bytes{std::ptrdiff_t{bytes_per_pixel(pixels.format)} * pixels.width_px};
  const std::ptrdiff_t stride{pixels.stride_bytes == 0 ? row_bytes : pixels.stride_bytes};
  const auto* const first{static_cast<const unsigned char*>(pixels.data)};
  for (int v{0}; v < pixels.height_px; ++v) convert_row(pixels, first + v * stride, grey.row(v));
}

}  // namespace stereogrid
