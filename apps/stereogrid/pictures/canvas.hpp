// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stereogrid/io/image_file.hpp"

namespace stereogrid::app {

struct Colour {
  std::uint8_t red{0};
  std::uint8_t green{0};
  std::uint8_t blue{0};

  friend bool operator==(const Colour&, const Colour&) = default;
};

/// Style sheet of all pages (viewer/theme.css).
[[nodiscard]] std::string_view theme_css();
/// A colour of its light theme, such as "--cell-free".
[[nodiscard]] Colour theme_colour(std::string_view name);

/// Part of a canvas, in pixels.
struct Box {
  int x{0};
  int y{0};
  int width{0};
  int height{0};
};

using Points = std::vector<cv::Point2d>;

struct Stroke {
  Colour colour;
  double width_px{1};
  bool is_closed{false};
};

enum class Align { left, centre, right };

struct TextStyle {
  Colour colour;
  double size_px{16};
  Align align{Align::left};
  double halo_px{0};  ///< paper around the letters: readable on any background
  bool upwards{false};
};

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

/// Surface of a visualisation: pixels or SVG. Coordinates are in px from the top left corner of the innermost part.
class Canvas {
 public:
  Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  virtual ~Canvas() = default;

  /// Clips to a box, and moves the origin to its corner, until end_part().
  virtual void begin_part(const Box& box) = 0;
  virtual void end_part() = 0;
  /// RGB pixels over a box. `smooth`: interpolated when enlarged.
  virtual void image(const Box& box, const cv::Mat& rgb, bool smooth) = 0;
  virtual void fill(const Points& corners, Colour colour) = 0;
  virtual void line(const Points& points, const Stroke& stroke) = 0;
  /// `at`: left end, middle or right end of the base line.
  virtual void text(cv::Point2d at, std::string_view utf8, const TextStyle& style) = 0;
};

/// Pixels; lines and letters are antialiased.
class PixelCanvas final : public Canvas {
 public:
  PixelCanvas(int width, int height);

  void begin_part(const Box& box) override;
  void end_part() override;
  void image(const Box& box, const cv::Mat& rgb, bool smooth) override;
  void fill(const Points& corners, Colour colour) override;
  void line(const Points& points, const Stroke& stroke) override;
  void text(cv::Point2d at, std::string_view utf8, const TextStyle& style) override;

  [[nodiscard]] io::RgbImage result() { return std::move(image_); }

 private:
  io::RgbImage image_;
  std::vector<cv::Mat> parts_;  // the innermost is the last
};

/// SVG 1.1: lines and letters are elements, images are embedded as PNG.
class SvgCanvas final : public Canvas {
 public:
  SvgCanvas(int width, int height);

  void begin_part(const Box& box) override;
  void end_part() override;
  void image(const Box& box, const cv::Mat& rgb, bool smooth) override;
  void fill(const Points& corners, Colour colour) override;
  void line(const Points& points, const Stroke& stroke) override;
  void text(cv::Point2d at, std::string_view utf8, const TextStyle& style) override;

  /// The file.
  [[nodiscard]] std::string result() { return std::move(svg_) + "</svg>\n"; }

 private:
  std::string svg_;
};

}  // namespace stereogrid::app
