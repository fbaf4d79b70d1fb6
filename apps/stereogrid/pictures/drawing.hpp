// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

namespace stereogrid::app {

struct Colour {
  std::uint8_t red{0};
  std::uint8_t green{0};
  std::uint8_t blue{0};

  friend bool operator==(const Colour&, const Colour&) = default;
};

namespace palette {
constexpr Colour paper{250, 250, 248};
constexpr Colour ink{32, 34, 38};
constexpr Colour faint_ink{110, 114, 120};
constexpr Colour frame{150, 154, 160};
constexpr Colour upright{230, 40, 40};
constexpr Colour road{50, 110, 255};
constexpr Colour ruler{60, 130, 190};
constexpr Colour obstacle{235, 120, 0};
constexpr Colour drop{190, 40, 200};
}  // namespace palette

/// Part of a canvas, in pixels.
struct Box {
  int x{0};
  int y{0};
  int width{0};
  int height{0};
};

[[nodiscard]] inline cv::Scalar scalar(Colour colour) {
  return {double(colour.red), double(colour.green), double(colour.blue)};
}

enum class Align { left, centre, right };

// Canvases are 8-bit R G B.

/// ASCII text; (x, y) is the left end, middle or right end of its base line.
void draw_text(cv::Mat& canvas, int x, int y, const std::string& text, Colour colour = palette::ink,
               Align align = Align::left, double size = 0.45);
/// The same, readable on any background.
void draw_text_on_picture(cv::Mat& canvas, int x, int y, const std::string& text, Colour colour,
                          Align align = Align::left);
void fill_box(cv::Mat& canvas, const Box& box, Colour colour);
void frame_box(cv::Mat& canvas, const Box& box);

/// White free, black occupied, mid grey unknown.
[[nodiscard]] std::uint8_t grey_of(float occupancy);
/// A colour per direction in the vehicle's plane (rad, 0 ahead, counter-clockwise).
[[nodiscard]] Colour colour_of_direction(double direction_rad);

}  // namespace stereogrid::app
