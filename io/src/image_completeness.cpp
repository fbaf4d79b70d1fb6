// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "image_completeness.hpp"

#include <zlib.h>

#include <cctype>
#include <cstdint>
#include <optional>
#include <string_view>

#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

constexpr std::string_view png_signature{"\x89PNG\r\n\x1a\n", 8};

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw InputError{file, what, "Copy or record it again."};
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value{0};
  for (const char byte : bytes.substr(0, 4)) value = value << 8 | static_cast<std::uint8_t>(byte);
  return value;
}

std::string checked_png(const std::string& file, std::string_view bytes) {
  std::string kept{png_signature};
  bytes.remove_prefix(png_signature.size());
  while (bytes.size() >= 12) {
    const std::size_t length{big_endian(bytes)};
    if (length > bytes.size() - 12) break;
    const std::string_view type{bytes.substr(4, 4)};
    const std::string_view covered{bytes.substr(4, length + 4)};
    const auto checksum{::crc32(0, reinterpret_cast<const Bytef*>(covered.data()), static_cast<uInt>(covered.size()))};
    if (checksum != big_endian(bytes.substr(length + 8))) {
      fail(file, "is a damaged PNG (wrong checksum in chunk " + std::string{type} + ").");
    }
    // an upper-case first letter marks the chunks that decoding needs; tRNS is not wanted: alpha is no brightness
    if (std::isupper(static_cast<unsigned char>(type[0])) != 0) kept += bytes.substr(0, length + 12);
    if (type == "IEND") return kept;
    bytes.remove_prefix(length + 12);
  }
  fail(file, "is a truncated PNG (its end is missing).");
}

void check_jpeg(const std::string& file, std::string_view bytes) {
  std::size_t at{2};
  while (at + 4 <= bytes.size() && bytes[at] == '\xff') {
    const auto marker{static_cast<std::uint8_t>(bytes[at + 1])};
    if (marker == 0xff) {
      ++at;
      continue;
    }
    if (marker == 0xda) {  // the scan: only the true end marker follows, since 0xff is escaped in it
      if (bytes.find("\xff\xd9", at) != std::string_view::npos) return;
      break;
    }
    at += 2 + (static_cast<std::size_t>(static_cast<std::uint8_t>(bytes[at + 2])) << 8 |
               static_cast<std::uint8_t>(bytes[at + 3]));
  }
  fail(file, "is a truncated or damaged JPEG (its end is missing).");
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
  const std::uint64_t samples{*width * *height * (kind == '3' || kind == '6' ? 3 : 1)};
  if (kind == '5' || kind == '6') {
    if (words.rest() < samples * (*maximum > 255 ? 2 : 1)) fail(file, "is a truncated PGM (pixels are missing).");
    return;
  }
  for (std::uint64_t i{0}; i < samples; ++i) {
    if (!words.number()) fail(file, "is a truncated PGM (pixels are missing).");
  }
}

}  // namespace

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
  throw InputError{file, "is no image of a kind that can be read.", "Use PNG, PGM, PPM or JPEG."};
}

}  // namespace stereogrid::io
