// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "files/image_completeness.hpp"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "files/png.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw InputError{file, what, "Copy or record it again."};
}

void check_size(const std::string& file, std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0) fail(file, "has no pixels.");
  if (std::max(width, height) <= largest_side_px && width * height <= most_pixels) return;
  throw InputError{file, fmt::format("says that it has {} × {} px.", width, height),
                   fmt::format("Images of up to {} px a side and {} million pixels can be read.", largest_side_px,
                               most_pixels / 1'000'000)};
}

std::string checked_png(const std::string& file, std::string_view bytes) {
  std::string kept{png_signature};
  bytes.remove_prefix(png_signature.size());
  while (const auto chunk = take_png_chunk(bytes)) {
    const std::string_view content{chunk->content()};
    if (libdeflate_crc32(0, chunk->covered.data(), chunk->covered.size()) != chunk->checksum) {
      fail(file, "is a damaged PNG (wrong checksum in chunk '" + printable(chunk->type()) + "').");
    }
    if (chunk->type() == "IHDR" && content.size() >= 8) {
      check_size(file, big_endian(content), big_endian(content.substr(4)));
    }
    // an upper-case first letter marks the chunks that decoding needs; tRNS is not wanted: alpha is no brightness
    if (std::isupper(static_cast<unsigned char>(chunk->type()[0])) != 0) kept += chunk->whole;
    if (chunk->type() == "IEND") return kept;
  }
  fail(file, "is a truncated PNG (its end is missing).");
}

std::size_t big_endian_16(std::string_view bytes, std::size_t at) {
  return static_cast<std::size_t>(static_cast<std::uint8_t>(bytes[at])) << 8 | static_cast<std::uint8_t>(bytes[at + 1]);
}

/// Marker at or after `at`, as libjpeg finds it: bytes of a scan, escaped 0xff and fill bytes are passed over.
std::size_t next_marker(std::string_view bytes, std::size_t at) {
  while (at + 1 < bytes.size() && (bytes[at] != '\xff' || bytes[at + 1] == '\0' || bytes[at + 1] == '\xff')) ++at;
  return at;
}

/// Reads the markers as libjpeg does, which must not find a frame that is not checked here.
void check_jpeg(const std::string& file, std::string_view bytes) {
  constexpr int most_scans{32};
  int scans{0};
  for (std::size_t at{next_marker(bytes, 2)}; at + 2 <= bytes.size(); at = next_marker(bytes, at)) {
    const auto marker{static_cast<std::uint8_t>(bytes[at + 1])};
    if (marker == 0xd9 && scans > 0) return;
    if (marker == 0xd9) break;
    at += 2;
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7)) continue;  // no length
    const std::size_t length{at + 2 <= bytes.size() ? big_endian_16(bytes, at) : 0};
    if (marker < 0xc0 || marker == 0xd8 || length < 2 || length > bytes.size() - at) break;
    const bool is_frame{marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc};
    if (is_frame && length >= 7) check_size(file, big_endian_16(bytes, at + 5), big_endian_16(bytes, at + 3));
    if (marker == 0xda && ++scans > most_scans) {
      throw InputError{file, fmt::format("is a JPEG of more than {} scans.", most_scans), "Write it again."};
    }
    at += length;
  }
  fail(file, "is a truncated or damaged JPEG (its end is missing).");
}

std::size_t little_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::size_t value{0};
  for (std::size_t i{count}; i > 0; --i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i - 1]);
  return value;
}

/// The first chunk says the size: VP8X that of the canvas, VP8L and VP8 that of the image.
void check_webp(const std::string& file, std::string_view bytes) {
  constexpr std::size_t head_bytes{30};
  if (bytes.size() < head_bytes || bytes.size() - 8 < little_endian(bytes, 4, 4)) {
    fail(file, "is a truncated WebP (its end is missing).");
  }
  const std::string_view chunk{bytes.substr(12, 4)};
  if (chunk == "VP8X") {
    check_size(file, little_endian(bytes, 24, 3) + 1, little_endian(bytes, 27, 3) + 1);
  } else if (chunk == "VP8L") {
    const std::size_t sizes{little_endian(bytes, 21, 4)};
    check_size(file, (sizes & 0x3fff) + 1, (sizes >> 14 & 0x3fff) + 1);
  } else if (chunk == "VP8 ") {
    check_size(file, little_endian(bytes, 26, 2) & 0x3fff, little_endian(bytes, 28, 2) & 0x3fff);
  } else {
    fail(file, "is a damaged WebP (its first chunk is none of an image).");
  }
}

/// Rows of a negative height come from the top.
void check_bmp(const std::string& file, std::string_view bytes) {
  constexpr std::size_t head_bytes{54};
  if (bytes.size() < head_bytes || bytes.size() < little_endian(bytes, 2, 4)) {
    fail(file, "is a truncated BMP (its end is missing).");
  }
  const auto height{static_cast<std::int32_t>(little_endian(bytes, 22, 4))};
  check_size(file, little_endian(bytes, 18, 4), static_cast<std::uint64_t>(std::abs(std::int64_t{height})));
}

/// Reads the white-space separated words of a PNM header, comments left out.
class PnmWords {
 public:
  explicit PnmWords(std::string_view bytes) : bytes_{bytes} {}

  std::optional<std::uint64_t> number() {
    skip_space();
    std::uint64_t value{0};
    const std::size_t start{at_};
    while (at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9' && value < 1'000'000'000) {
      value = value * 10 + static_cast<std::uint64_t>(bytes_[at_++] - '0');
    }
    return at_ > start ? std::optional{value} : std::nullopt;
  }

  /// Bytes after the one white-space character that ends the header.
  [[nodiscard]] std::size_t rest() const { return at_ < bytes_.size() ? bytes_.size() - at_ - 1 : 0; }

 private:
  void skip_space() {
    while (at_ < bytes_.size() && (bytes_[at_] == '#' || std::isspace(static_cast<unsigned char>(bytes_[at_])) != 0)) {
      if (bytes_[at_] == '#') {
        while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
      } else {
        ++at_;
      }
    }
  }

  std::string_view bytes_;
  std::size_t at_{0};
};

void check_pnm(const std::string& file, std::string_view bytes) {
  const char kind{bytes[1]};
  PnmWords words{bytes.substr(2)};
  const auto width{words.number()};
  const auto height{words.number()};
  const auto maximum{words.number()};
  if (!width || !height || !maximum || *maximum == 0 || *maximum > 65535) fail(file, "has a damaged PGM header.");
  check_size(file, *width, *height);
  const std::uint64_t samples{*width * *height * (kind == '3' || kind == '6' ? 3 : 1)};
  if (kind == '5' || kind == '6') {
    if (words.rest() < samples * (*maximum > 255 ? 2 : 1)) fail(file, "is a truncated PGM (pixels are missing).");
    return;
  }
  for (std::uint64_t i{0}; i < samples; ++i) {
    if (!words.number()) fail(file, "is a truncated PGM (pixels are missing).");
  }
}

/// Unsigned integers of a TIFF in its byte order; 0 behind its end.
class TiffNumbers {
 public:
  explicit TiffNumbers(std::string_view bytes) : bytes_{bytes}, little_{bytes.starts_with("II")} {}

  [[nodiscard]] std::uint64_t at(std::uint64_t place, std::size_t size) const {
    if (place > bytes_.size() || size > bytes_.size() - place) return 0;
    std::uint64_t value{0};
    for (std::size_t i{0}; i < size; ++i) {
      value = value << 8 | static_cast<std::uint8_t>(bytes_[place + (little_ ? size - 1 - i : i)]);
    }
    return value;
  }

 private:
  std::string_view bytes_;
  bool little_;
};

}  // namespace

void check_tiff_size(const std::string& file, std::string_view bytes) {
  const TiffNumbers numbers{bytes};
  const bool big{numbers.at(2, 2) == 43};
  const std::uint64_t directory{big ? numbers.at(8, 8) : numbers.at(4, 4)};
  const std::uint64_t entries{std::min<std::uint64_t>(numbers.at(directory, big ? 8 : 2), 65535)};
  const auto entry{[&](std::uint64_t i) { return directory + (big ? 8 + 20 * i : 2 + 12 * i); }};
  std::uint64_t width{0};
  std::uint64_t height{0};
  std::uint64_t bits{8};
  std::uint64_t samples{1};
  std::uint64_t tile_width{1};
  std::uint64_t tile_height{1};
  for (std::uint64_t i{0}; i < entries && entry(i) < bytes.size(); ++i) {
    constexpr std::uint64_t type_short{3}, type_long{4}, type_long8{16};
    constexpr std::uint64_t tag_width{256}, tag_height{257}, tag_bits{258}, tag_samples{277}, tag_tile_width{322},
        tag_tile_height{323};
    const std::uint64_t tag{numbers.at(entry(i), 2)};
    if (tag == tag_bits) {  // one value per sample; three and more are stored outside the entry
      const std::uint64_t place{entry(i) + (big ? 12 : 8)};
      const bool is_here{numbers.at(entry(i) + 4, big ? 8 : 4) <= (big ? 4 : 2)};
      bits = std::max(bits, numbers.at(is_here ? place : numbers.at(place, big ? 8 : 4), 2));
    }
    if (tag != tag_width && tag != tag_height && tag != tag_samples && tag != tag_tile_width &&
        tag != tag_tile_height) {
      continue;
    }
    // the decoder reads other types and several values outside the entry
    const std::uint64_t type{numbers.at(entry(i) + 2, 2)};
    const bool has_type{type == type_short || type == type_long || (big && type == type_long8)};
    if (!has_type || numbers.at(entry(i) + 4, big ? 8 : 4) != 1) {
      fail(file, fmt::format("is a damaged TIFF (the type of tag {} is {}).", tag, type));
    }
    const std::size_t size{type == type_short ? 2U : type == type_long ? 4U : 8U};
    const std::uint64_t value{numbers.at(entry(i) + (big ? 12 : 8), size)};
    if (tag == tag_width) width = std::max(width, value);
    if (tag == tag_height) height = std::max(height, value);
    if (tag == tag_tile_width) tile_width = std::max(tile_width, value);
    if (tag == tag_tile_height) tile_height = std::max(tile_height, value);
    if (tag == tag_samples && value > 4) fail(file, fmt::format("has {} samples a pixel (allowed: 1 to 4).", value));
    if (tag == tag_samples) samples = std::max(samples, value);
  }
  check_size(file, width, height);
  check_size(file, tile_width, tile_height);
  if (width * height * samples * bits / 8 > largest_bytes::image) {
    fail(file,
         fmt::format("has {} × {} px of {} samples with {} bits, more than 512 MiB.", width, height, samples, bits));
  }
}

std::string checked_image_bytes(const std::string& file, std::string bytes) {
  const std::string_view view{bytes};
  if (bytes.empty()) fail(file, "is empty.");
  if (view.starts_with(png_signature)) return checked_png(file, bytes);
  if (view.starts_with(png_signature.substr(0, view.size()))) fail(file, "is a truncated PNG.");
  if (view.starts_with("\xff\xd8")) {
    check_jpeg(file, bytes);
    return bytes;
  }
  if (view.size() > 2 && view[0] == 'P' && (view[1] == '2' || view[1] == '3' || view[1] == '5' || view[1] == '6')) {
    check_pnm(file, bytes);
    return bytes;
  }
  if (view.starts_with("RIFF") && view.find("WEBP") == 8) {
    check_webp(file, bytes);
    return bytes;
  }
  if (view.starts_with("II") || view.starts_with("MM")) {
    check_tiff_size(file, bytes);
    return bytes;
  }
  if (view.starts_with("BM")) {
    check_bmp(file, bytes);
    return bytes;
  }
  throw InputError{file, "is no image of a kind that can be read.", "Use PNG, PGM, PPM, JPEG, WebP, TIFF or BMP."};
}

}  // namespace stereogrid::io
