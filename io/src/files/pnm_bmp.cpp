// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "files/formats.hpp"

namespace stereogrid::io {
namespace {

/// Reads the white-space separated words of a PNM, comments left out.
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
  [[nodiscard]] std::string_view rest() const { return bytes_.substr(std::min(at_ + 1, bytes_.size())); }

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

[[noreturn]] void fail_truncated(const std::string& file) {
  fail_damaged(file, "is a truncated PGM (pixels are missing).");
}

template <class T, class Next>
void fill(cv::Mat& image, const Next& next) {
  for (int v{0}; v < image.rows; ++v) {
    T* const row{image.ptr<T>(v)};
    std::generate_n(row, image.cols * image.channels(), [&] { return static_cast<T>(next()); });
  }
}

}  // namespace

cv::Mat decode_pnm(const std::string& file, std::string_view bytes) {
  const char kind{bytes[1]};
  PnmWords words{bytes.substr(2)};
  const auto width{words.number()};
  const auto height{words.number()};
  const auto maximum{words.number()};
  if (!width || !height || !maximum || *maximum == 0 || *maximum > 65535) {
    fail_damaged(file, "has a damaged PGM header.");
  }
  check_size(file, *width, *height);
  const bool is_colour{kind == '3' || kind == '6'};
  const bool is_wide{*maximum > 255};
  const std::uint64_t samples{*width * *height * (is_colour ? 3 : 1)};
  const bool is_text{kind < '5'};
  const std::string_view pixels{words.rest()};
  if (pixels.size() < (is_text ? 2 * samples - 1 : samples * (is_wide ? 2 : 1))) fail_truncated(file);
  cv::Mat image(static_cast<int>(*height), static_cast<int>(*width),
                CV_MAKETYPE(is_wide ? CV_16U : CV_8U, is_colour ? 3 : 1));
  const auto* at{reinterpret_cast<const std::uint8_t*>(pixels.data())};
  const auto next_word{[&] {
    const auto value{words.number()};
    if (!value) fail_truncated(file);
    return std::min(*value, *maximum);
  }};
  if (is_text && is_wide) {
    fill<std::uint16_t>(image, next_word);
  } else if (is_text) {
    fill<std::uint8_t>(image, [&] { return next_word() * 255 / *maximum; });
  } else if (is_wide) {
    fill<std::uint16_t>(image, [&] { return at += 2, at[-2] << 8 | at[-1]; });
  } else {
    fill<std::uint8_t>(image, [&] { return *at++; });
  }
  if (is_colour) cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  return image;
}

namespace {

std::uint32_t little_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value{0};
  for (std::size_t i{count}; i > 0; --i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i - 1]);
  return value;
}

/// Replaces 8-bit indices by their colours (B G R 0). A grey palette makes a grey image.
cv::Mat coloured(const cv::Mat& indices, std::string_view palette) {
  cv::Mat4b colours(1, 256, cv::Vec4b{});
  std::ranges::copy(palette.substr(0, 1024), colours.ptr<char>());
  cv::Mat3b table;
  cv::cvtColor(colours, table, cv::COLOR_BGRA2BGR);
  cv::Mat image;
  cv::cvtColor(indices, image, cv::COLOR_GRAY2BGR);
  cv::LUT(image, table, image);
  const bool is_grey{std::ranges::all_of(table, [](const cv::Vec3b& c) { return c[0] == c[1] && c[1] == c[2]; })};
  if (is_grey) cv::extractChannel(image, image, 0);
  return image;
}

}  // namespace

cv::Mat decode_bmp(const std::string& file, std::string_view bytes) {
  constexpr std::uint32_t head_bytes{54};
  if (bytes.size() < head_bytes || bytes.size() < little_endian(bytes, 2, 4)) {
    fail_damaged(file, "is a truncated BMP (its end is missing).");
  }
  const std::uint32_t pixels{little_endian(bytes, 10, 4)};
  const std::uint32_t palette{14 + little_endian(bytes, 14, 4)};
  const auto width{static_cast<std::int32_t>(little_endian(bytes, 18, 4))};
  const auto signed_height{static_cast<std::int32_t>(little_endian(bytes, 22, 4))};
  const auto height{static_cast<std::uint64_t>(std::abs(std::int64_t{signed_height}))};
  check_size(file, static_cast<std::uint64_t>(std::max(width, 0)), height);
  const std::uint32_t bits{little_endian(bytes, 28, 2)};
  if ((bits != 8 && bits != 24 && bits != 32) || little_endian(bytes, 30, 4) != 0) {
    fail_unsupported(file, "is a compressed BMP, or one without 8, 24 or 32 bits a pixel.");
  }
  const std::size_t row_bytes{(static_cast<std::size_t>(width) * bits / 8 + 3) / 4 * 4};
  if (pixels < head_bytes || pixels > bytes.size() || bytes.size() - pixels < row_bytes * height || palette > pixels) {
    fail_damaged(file, "is a truncated BMP (its end is missing).");
  }
  const cv::Mat stored{static_cast<int>(height), width, CV_8UC(static_cast<int>(bits) / 8),
                       const_cast<char*>(bytes.data() + pixels), row_bytes};
  cv::Mat image{stored.clone()};
  if (signed_height > 0) cv::flip(stored, image, 0);
  if (bits == 8) return coloured(image, bytes.substr(palette, pixels - palette));
  if (bits == 32) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  return image;
}

}  // namespace stereogrid::io
