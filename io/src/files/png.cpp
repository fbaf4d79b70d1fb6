// SPDX-License-Identifier: Apache-2.0
//
// PNG (Third Edition), W3C Recommendation 2025: §5 chunks, §9 filters. With ISA-L, which is faster than libpng.
#include "files/formats.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value{0};
  for (const char byte : bytes.substr(0, 4)) value = value << 8 | static_cast<std::uint8_t>(byte);
  return value;
}

struct Chunk {
  std::string_view covered;  ///< part that the checksum is of: type and content
  std::uint32_t checksum;

  [[nodiscard]] std::string_view type() const { return covered.substr(0, 4); }
  [[nodiscard]] std::string_view content() const { return covered.substr(4); }
};

/// Removes the first chunk from `bytes`. Empty: they end within it.
std::optional<Chunk> take_chunk(std::string_view& bytes) {
  constexpr std::size_t frame_bytes{12};  // length, type, checksum
  if (bytes.size() < frame_bytes) return {};
  const std::size_t length{big_endian(bytes)};
  if (length > bytes.size() - frame_bytes) return {};
  const Chunk chunk{bytes.substr(4, length + 4), big_endian(bytes.substr(length + 8))};
  bytes.remove_prefix(length + frame_bytes);
  return chunk;
}

/// Parts of a file that its pixels are made of.
struct Parts {
  std::string_view header;
  std::string_view palette;
  std::string packed;
};

Parts parts_of(const std::string& file, std::string_view bytes) {
  Parts parts;
  parts.packed.reserve(bytes.size());
  bytes.remove_prefix(png_signature.size());
  while (const auto chunk = take_chunk(bytes)) {
    if (crc32_of(chunk->covered) != chunk->checksum) {
      fail_damaged(file, "is a damaged PNG (wrong checksum in chunk '" + printable(chunk->type()) + "').");
    }
    if (chunk->type() == "IHDR" && parts.header.empty()) parts.header = chunk->content();
    if (chunk->type() == "PLTE") parts.palette = chunk->content();
    if (chunk->type() == "IDAT") parts.packed += chunk->content();
    if (chunk->type() == "IEND") return parts;
  }
  fail_damaged(file, "is a truncated PNG (its end is missing).");
}

struct Header {
  int width;
  int height;
  int bits;  ///< per sample
  int channels;
  bool is_indexed;

  [[nodiscard]] std::size_t pixel_bytes() const { return static_cast<std::size_t>(std::max(1, bits * channels / 8)); }
  [[nodiscard]] std::size_t row_bytes() const {
    return (static_cast<std::size_t>(width) * static_cast<std::size_t>(bits * channels) + 7) / 8;
  }
};

Header header_of(const std::string& file, std::string_view chunk) {
  constexpr std::size_t bytes{13};
  if (chunk.size() != bytes) fail_damaged(file);
  check_size(file, big_endian(chunk), big_endian(chunk.substr(4)));
  constexpr int channels_of_type[]{1, 0, 3, 1, 2, 0, 4};  // grey, colour, indices, grey and colour with alpha
  const auto bits{static_cast<std::uint8_t>(chunk[8])};
  const auto type{static_cast<std::uint8_t>(chunk[9])};
  const int channels{type <= 6 ? channels_of_type[type] : 0};
  const bool has_few_bits{type == 0 || type == 3};
  if (channels == 0 || !std::has_single_bit(bits) || bits > (type == 3 ? 8 : 16) || (bits < 8 && !has_few_bits)) {
    fail_damaged(file);
  }
  if (chunk[12] != 0) fail_unsupported(file, "is an interlaced PNG.");
  return {static_cast<int>(big_endian(chunk)), static_cast<int>(big_endian(chunk.substr(4))), bits, channels,
          type == 3};
}

std::uint8_t paeth(int left, int above, int above_left) {
  const int estimate{left + above - above_left};
  const int of_left{std::abs(estimate - left)};
  const int of_above{std::abs(estimate - above)};
  const int of_both{std::abs(estimate - above_left)};
  if (of_left <= of_above && of_left <= of_both) return static_cast<std::uint8_t>(left);
  return static_cast<std::uint8_t>(of_above <= of_both ? above : above_left);
}

// row[i] += predict(left, above, above left), without a left neighbour in the first pixel. One byte of each pixel after
// the other: the left neighbour stays in a register, and need not be read again.
template <class Predict>
void add_prediction(std::uint8_t* row, const std::uint8_t* above, std::size_t bytes, std::size_t pixel_bytes,
                    const Predict& predict) {
  for (std::size_t first{0}; first < pixel_bytes; ++first) {
    std::uint8_t left{0};
    std::uint8_t above_left{0};
    for (std::size_t i{first}; i < bytes; i += pixel_bytes) {
      left = static_cast<std::uint8_t>(row[i] + predict(left, above[i], above_left));
      above_left = above[i];
      row[i] = left;
    }
  }
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

void copy_row(const Header& header, const std::uint8_t* from, std::uint8_t* to) {
  if (header.bits == 16) {  // stored with the most significant byte first
    const std::size_t order{std::endian::native == std::endian::little ? 1U : 0U};
    for (std::size_t i{0}; i < header.row_bytes(); ++i) to[i ^ order] = from[i];
    return;
  }
  const int largest{(1 << header.bits) - 1};
  for (int u{0}; u < header.width; ++u) {
    const int bit{u * header.bits};
    const int value{from[bit / 8] >> (8 - header.bits - bit % 8) & largest};
    to[u] = static_cast<std::uint8_t>(header.is_indexed ? value : value * 255 / largest);
  }
}

/// Image of unfiltered rows; bytes stay where they are.
cv::Mat unpacked(const Header& header, const cv::Mat& rows) {
  if (header.bits == 8) return rows.reshape(header.channels);
  cv::Mat image(header.height, header.width, CV_MAKETYPE(header.bits == 16 ? CV_16U : CV_8U, header.channels));
  for (int v{0}; v < header.height; ++v) copy_row(header, rows.ptr(v), image.ptr(v));
  return image;
}

/// Replaces indices by colours; those that the palette lacks are black.
cv::Mat coloured(const std::string& file, const cv::Mat& indices, std::string_view palette) {
  cv::Mat3b table(1, 256, cv::Vec3b{});
  if (palette.empty() || palette.size() % 3 != 0 || palette.size() > table.total() * 3) fail_damaged(file);
  std::ranges::copy(palette, table.ptr<char>());
  cv::Mat image;
  cv::cvtColor(indices, image, cv::COLOR_GRAY2BGR);
  cv::LUT(image, table, image);
  return image;
}

}  // namespace

cv::Mat decode_png(const std::string& file, std::string_view bytes) {
  const Parts parts{parts_of(file, bytes)};
  const Header header{header_of(file, parts.header)};
  const std::size_t stored_bytes{1 + header.row_bytes()};  // the filter in front
  const std::size_t all_bytes{stored_bytes * static_cast<std::size_t>(header.height)};
  constexpr std::size_t largest_ratio{1032};  // deflate's: a small file does not reserve a large image
  if (all_bytes / largest_ratio > parts.packed.size()) fail_damaged(file);
  cv::Mat rows(header.height, static_cast<int>(stored_bytes), CV_8U);
  if (!inflate_zlib(parts.packed, {rows.data, rows.total()})) fail_damaged(file);
  const std::vector<std::uint8_t> nothing_above(stored_bytes, 0);
  const std::uint8_t* above{nothing_above.data()};
  for (int v{0}; v < header.height; ++v) {
    std::uint8_t* const row{rows.ptr(v) + 1};
    if (!remove_filter(row[-1], row, above, header.row_bytes(), header.pixel_bytes())) fail_damaged(file);
    above = row;
  }
  cv::Mat image{unpacked(header, rows.colRange(1, rows.cols))};
  if (header.is_indexed) image = coloured(file, image, parts.palette);
  if (image.channels() == 2) cv::extractChannel(image, image, 0);
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_RGBA2BGR);
  return image;
}

namespace {

std::string text_of(std::uint32_t number) {
  std::string bytes;
  for (int shift{24}; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  return bytes;
}

void add_chunk(std::string& png, std::string_view type, std::string_view content) {
  png += text_of(static_cast<std::uint32_t>(content.size()));
  const std::size_t start{png.size()};
  png.append(type).append(content);
  png += text_of(crc32_of(std::string_view{png}.substr(start)));
}

}  // namespace

// Rows are stored as their difference from the one above (filter 2). A choice per row saves 5 % of a camera's image and
// nothing of a visualisation.
std::string encode_png(const cv::Mat& image) {
  cv::Mat stored;
  if (image.channels() == 3) cv::cvtColor(image, stored, cv::COLOR_BGR2RGB);
  if (image.channels() == 1) stored = image;
  const bool is_wide{image.depth() == CV_16U};
  const std::size_t row_bytes{static_cast<std::size_t>(image.cols) * image.elemSize()};
  const std::size_t order{is_wide && std::endian::native == std::endian::little ? 1U : 0U};
  std::string rows;
  rows.reserve((1 + row_bytes) * static_cast<std::size_t>(image.rows));
  for (int v{0}; v < image.rows; ++v) {
    rows += '\2';
    const std::uint8_t* const row{stored.ptr(v)};
    const std::uint8_t* const above{v > 0 ? stored.ptr(v - 1) : nullptr};
    for (std::size_t i{0}; i < row_bytes; ++i)
      rows += static_cast<char>(row[i ^ order] - (above ? above[i ^ order] : 0));
  }
  std::string png{png_signature};
  add_chunk(png, "IHDR",
            text_of(static_cast<std::uint32_t>(image.cols)) + text_of(static_cast<std::uint32_t>(image.rows)) +
                (is_wide ? '\x10' : '\x08') + (image.channels() == 3 ? '\2' : '\0') + std::string(3, '\0'));
  add_chunk(png, "IDAT", deflate(rows, DeflateForm::zlib));
  add_chunk(png, "IEND", {});
  return png;
}

}  // namespace stereogrid::io
