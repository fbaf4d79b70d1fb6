// SPDX-License-Identifier: Apache-2.0
#include "pictures/canvas.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <utility>

namespace stereogrid::app {
namespace {

constexpr double units_per_em{512};

/// Takes the first code point off a text.
char32_t next_code(std::string_view& utf8) {
  const auto byte = [&](std::size_t i) { return i < utf8.size() ? static_cast<unsigned char>(utf8[i]) : 0U; };
  const std::size_t length{byte(0) < 0x80 ? 1U : byte(0) < 0xE0 ? 2U : byte(0) < 0xF0 ? 3U : 4U};
  char32_t code{length == 1 ? byte(0) : byte(0) & (0xFFU >> (length + 1))};
  for (std::size_t i{1}; i < length; ++i) code = code << 6 | (byte(i) & 0x3FU);
  utf8.remove_prefix(std::min(length, utf8.size()));
  return code;
}

const Letter& letter_of(char32_t code) {
  const auto found{std::ranges::lower_bound(roboto, code, {}, &Letter::code)};
  return found != roboto.end() && found->code == code ? *found : letter_of(U'?');
}

std::vector<std::vector<cv::Point2d>> parsed(std::string_view text) {
  std::vector<std::vector<cv::Point2d>> contours;
  const char* at{text.data()};
  const char* const end{at + text.size()};
  for (char before{';'}; at < end; before = at < end ? *at++ : ';') {
    if (before == ';') contours.emplace_back();
    int x{0};
    int y{0};
    at = std::from_chars(at, end, x).ptr + 1;
    at = std::from_chars(at, end, y).ptr;
    contours.back().emplace_back(x, y);
  }
  return contours;
}

}  // namespace

double text_width(std::string_view utf8, double size_px) {
  int width{0};
  while (!utf8.empty()) width += letter_of(next_code(utf8)).advance;
  return width * size_px / units_per_em;
}

std::vector<std::vector<cv::Point2d>> text_contours(std::string_view utf8, double size_px) {
  const double scale{size_px / units_per_em};
  std::vector<std::vector<cv::Point2d>> made;
  int x{0};
  while (!utf8.empty()) {
    const Letter& letter{letter_of(next_code(utf8))};
    for (std::vector<cv::Point2d>& contour : parsed(letter.contours)) {
      for (cv::Point2d& point : contour) point = {scale * (x + point.x), -scale * point.y};
      made.push_back(std::move(contour));
    }
    x += letter.advance;
  }
  return made;
}

}  // namespace stereogrid::app
