// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// PNG (Third Edition), W3C Recommendation 2025: §5 chunks, §9 filters.
#include "files/png.hpp"

#include <libdeflate.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace stereogrid::io {
namespace {

struct Header {
  int width{0};
  int height{0};
  int bytes_per_sample{0};  // 0: a kind that is not decoded here
  int channels{0};
};

Header header_of(std::string_view chunk) {
  constexpr std::size_t bytes{13};
  if (chunk.size() != bytes) return {};
  const int bits{chunk[8]};
  const int colour_type{chunk[9]};
  const bool is_plain{(bits == 8 || bits == 16) && (colour_type == 0 || colour_type == 2) && chunk[12] == 0};
  return {static_cast<int>(big_endian(chunk)), static_cast<int>(big_endian(chunk.substr(4))), is_plain ? bits / 8 : 0,
          colour_type == 2 ? 3 : 1};
}

std::uint8_t paeth(int left, int above, int above_left) {
  const int estimate{left + above - above_left};
  const int of_left{std::abs(estimate - left)};
  const int of_above{std::abs(estimate - above)};
  const int of_both{std::abs(estimate - above_left)};
  if (of_left <= of_above && of_left <= of_both) return static_cast<std::uint8_t>(left);
  return static_cast<std::uint8_t>(of_above <= of_both ? above : above_left);
}

// row[i] += predict(left, above, above left), without a left neighbour in the first pixel.
template <class Predict>
void add_prediction(std::uint8_t* row, const std::uint8_t* above, std::size_t bytes, std::size_t pixel_bytes,
                    const Predict& predict) {
  const auto add = [&](std::size_t i, int left, int above_left) {
    row[i] = static_cast<std::uint8_t>(row[i] + predict(left, above[i], above_left));
  };
  for (std::size_t i{0}; i < pixel_bytes; ++i) add(i, 0, 0);
  for (std::size_t i{pixel_bytes}; i < bytes; ++i) add(i, row[i - pixel_bytes], above[i - pixel_bytes]);
}

// False: a filter that does not exist.
bool remove_filter(int filter, std::uint8_t* row, const std::uint8_t* above, std::size_t bytes,
                   std::size_t pixel_bytes) {
  const auto with = [&](const auto& predict) { add_prediction(row, above, bytes, pixel_bytes, predict); };
  switch (filter) {
    case 0:
      return true;
    case 1:
      with([](int left, int, int) { return left; });
      return true;
    case 2:
      for (std::size_t i{0}; i < bytes; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
      return true;
    case 3:
      with([](int left, int over, int) { return (left + over) / 2; });
      return true;
    case 4:
      with(paeth);
      return true;
    default:
      return false;
  }
}

bool inflate(const std::string& packed, std::vector<std::uint8_t>& bytes) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor{
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor};
  return decompressor != nullptr &&
         libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), bytes.data(), bytes.size(),
                                    nullptr) == LIBDEFLATE_SUCCESS;
}

// Samples of 16 bits are stored with the most significant byte first.
void copy_row(const std::uint8_t* from, std::size_t bytes, int bytes_per_sample, std::uint8_t* to) {
  const bool swaps{bytes_per_sample == 2 && std::endian::native == std::endian::little};
  for (std::size_t i{0}; i < bytes; ++i) to[swaps ? i ^ 1 : i] = from[i];
}

}  // namespace

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value{0};
  for (const char byte : bytes.substr(0, 4)) value = value << 8 | static_cast<std::uint8_t>(byte);
  return value;
}

std::optional<PngChunk> take_png_chunk(std::string_view& bytes) {
  constexpr std::size_t frame_bytes{12};  // length, type, checksum
  if (bytes.size() < frame_bytes) return {};
  const std::size_t length{big_endian(bytes)};
  if (length > bytes.size() - frame_bytes) return {};
  const std::string_view whole{bytes.substr(0, length + frame_bytes)};
  bytes.remove_prefix(whole.size());
  return PngChunk{whole, whole.substr(4, length + 4), big_endian(whole.substr(length + 8))};
}

cv::Mat decode_plain_png(std::string_view bytes) {
  Header header;
  std::string packed;
  bytes.remove_prefix(png_signature.size());
  while (const auto chunk = take_png_chunk(bytes)) {
    if (chunk->type() == "IHDR") header = header_of(chunk->content());
    if (chunk->type() == "IDAT") packed += chunk->content();
  }
  if (header.bytes_per_sample == 0) return {};
  const std::size_t pixel_bytes{static_cast<std::size_t>(header.channels) *
                                static_cast<std::size_t>(header.bytes_per_sample)};
  const std::size_t row_bytes{pixel_bytes * static_cast<std::size_t>(header.width)};
  std::vector<std::uint8_t> rows((1 + row_bytes) * static_cast<std::size_t>(header.height));
  if (!inflate(packed, rows)) return {};
  cv::Mat image(header.height, header.width,  // braces would make a list of three numbers
                CV_MAKETYPE(header.bytes_per_sample == 1 ? CV_8U : CV_16U, header.channels));
  const std::vector<std::uint8_t> nothing_above(row_bytes, 0);
  const std::uint8_t* above{nothing_above.data()};
  for (int v{0}; v < header.height; ++v) {
    std::uint8_t* const row{rows.data() + (1 + row_bytes) * static_cast<std::size_t>(v) + 1};
    if (!remove_filter(row[-1], row, above, row_bytes, pixel_bytes)) return {};
    copy_row(row, row_bytes, header.bytes_per_sample, image.ptr(v));
    above = row;
  }
  if (header.channels == 3) cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  return image;
}

}  // namespace stereogrid::io
