// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cstdint>
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

}  // namespace stereogrid::io
