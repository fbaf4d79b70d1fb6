// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>

#include "pictures/canvas.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

std::string hex(Colour colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

std::string text_of(const Points& points) {
  std::string text;
  for (const cv::Point2d& point : points) text += fmt::format("{:.1f},{:.1f} ", point.x, point.y);
  return text;
}

std::string escaped(std::string_view text) {
  std::string made;
  for (const char letter : text) {
    made += letter == '<' ? "&lt;" : letter == '&' ? "&amp;" : letter == '"' ? "&quot;" : std::string{letter};
  }
  return made;
}

}  // namespace

SvgCanvas::SvgCanvas(int width, int height)
    : svg_{fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
                       "width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" font-family=\"{2}\" "
                       "xml:space=\"preserve\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n",
                       width, height, font_family)} {}

void SvgCanvas::begin_part(const Box& box) {
  svg_ += fmt::format("<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\">\n", box.x, box.y, box.width, box.height);
}

void SvgCanvas::end_part() {
  svg_ += "</svg>\n";
}

void SvgCanvas::image(const Box& box, const cv::Mat& rgb, bool smooth) {
  io::RgbImage pixels{rgb.cols, rgb.rows, {3 * rgb.cols, rgb.rows}};
  rgb.copyTo(cv::Mat{rgb.rows, rgb.cols, CV_8UC3, pixels.pixels.data()});
  svg_ += fmt::format(
      "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"{} "
      "xlink:href=\"data:image/png;base64,{}\"/>\n",
      box.x, box.y, box.width, box.height, smooth ? "" : " style=\"image-rendering:pixelated\"",
      io::base64(io::encode_png(pixels)));
}

void SvgCanvas::fill(const Points& corners, Colour colour) {
  svg_ += fmt::format("<polygon points=\"{}\" fill=\"{}\"/>\n", text_of(corners), hex(colour));
}

void SvgCanvas::line(const Points& points, const Stroke& stroke) {
  svg_ += fmt::format("<{} points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\"/>\n",
                      stroke.is_closed ? "polygon" : "polyline", text_of(points), hex(stroke.colour), stroke.width_px);
}

void SvgCanvas::text(cv::Point2d at, std::string_view utf8, const TextStyle& style) {
  static constexpr std::array anchors{"start", "middle", "end"};
  std::string more;
  if (style.halo_px > 0) {
    more += fmt::format(" stroke=\"{}\" stroke-width=\"{:g}\" paint-order=\"stroke\"", hex(theme_colour("--card")),
                        2 * style.halo_px);
  }
  if (style.upwards) more += fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", at.x, at.y);
  svg_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" text-anchor=\"{}\" fill=\"{}\"{}>{}</text>\n",
                      at.x, at.y, style.size_px, anchors.at(static_cast<std::size_t>(style.align)), hex(style.colour),
                      more, escaped(utf8));
}

}  // namespace stereogrid::app
