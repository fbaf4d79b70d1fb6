// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

namespace stereogrid::app {

/// A letter of a font, in 1/512 em.
struct Letter {
  char32_t code;
  int advance;
  std::string_view contours;  ///< corners "x,y x,y …" over the base line, contours separated by ";"
};

/// Roboto Regular (Apache-2.0), in the order of codes.
extern const std::array<Letter, 99> roboto;

constexpr const char* font_family{"Roboto, 'Helvetica Neue', Arial, sans-serif"};

/// Width of a text, px. `size_px`: an em. Letters that the font lacks are question marks.
[[nodiscard]] double text_width(std::string_view utf8, double size_px);

/// Contours of a text in px, x to the right and y downwards, from the left end of the base line. Filled by the even-odd
/// rule.
[[nodiscard]] std::vector<std::vector<cv::Point2d>> text_contours(std::string_view utf8, double size_px);

}  // namespace stereogrid::app
