// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pictures/canvas.hpp"

namespace stereogrid::app {
namespace {

constexpr int shift{4};  // fixed-point bits of OpenCV's pixels
constexpr int finer{4};  // letters are drawn larger, then reduced

cv::Scalar scalar(Colour colour) {
  return {double(colour.red), double(colour.green), double(colour.blue)};
}

/// Centres of OpenCV's pixels are whole numbers.
std::vector<cv::Point> fixed(const Points& points, double scale = 1) {
  std::vector<cv::Point> made;
  for (const cv::Point2d& point : points) {
    made.emplace_back(static_cast<int>(std::lround((scale * point.x - 0.5) * (1 << shift))),
                      static_cast<int>(std::lround((scale * point.y - 0.5) * (1 << shift))));
  }
  return made;
}

/// Blends a colour into pixels, by shares of 0 to 255.
void blend(cv::Mat pixels, const cv::Mat1b& shares, Colour colour) {
  for (int v{0}; v < pixels.rows; ++v) {
    for (int u{0}; u < pixels.cols; ++u) {
      const int share{shares(v, u)};
      auto& pixel{pixels.at<cv::Vec3b>(v, u)};
      const int target[3]{colour.red, colour.green, colour.blue};
      for (int i{0}; i < 3; ++i)
        pixel[i] = static_cast<std::uint8_t>((pixel[i] * (255 - share) + target[i] * share + 127) / 255);
    }
  }
}

cv::Mat1b reduced(const cv::Mat1b& fine) {
  cv::Mat1b shares;
  cv::resize(fine, shares, fine.size() / finer, 0, 0, cv::INTER_AREA);
  return shares;
}

}  // namespace

PixelCanvas::PixelCanvas(int width, int height) : image_{width, height, {3 * width, height}} {
  parts_.emplace_back(height, width, CV_8UC3, image_.pixels.data());
}

void PixelCanvas::begin_part(const Box& box) {
  parts_.push_back(parts_.back()(cv::Rect{box.x, box.y, box.width, box.height}));
}

void PixelCanvas::end_part() {
  parts_.pop_back();
}

void PixelCanvas::image(const Box& box, const cv::Mat& rgb, bool smooth) {
  cv::Mat part{parts_.back()(cv::Rect{box.x, box.y, box.width, box.height})};
  const int enlarged{smooth ? cv::INTER_LINEAR : cv::INTER_NEAREST};
  cv::resize(rgb, part, part.size(), 0, 0, box.width < rgb.cols || box.height < rgb.rows ? cv::INTER_AREA : enlarged);
}

void PixelCanvas::fill(const Points& corners, Colour colour) {
  cv::fillPoly(parts_.back(), std::vector{fixed(corners)}, scalar(colour), cv::LINE_AA, shift);
}

void PixelCanvas::line(const Points& points, const Stroke& stroke) {
  const int width{std::max(1, static_cast<int>(std::lround(stroke.width_px)))};
  cv::polylines(parts_.back(), fixed(points), stroke.is_closed, scalar(stroke.colour), width, cv::LINE_AA, shift);
}

void PixelCanvas::text(cv::Point2d at, std::string_view utf8, const TextStyle& style) {
  const double width{text_width(utf8, style.size_px)};
  const double before{style.align == Align::left ? 0 : style.align == Align::centre ? width / 2 : width};
  const int margin{static_cast<int>(std::ceil(style.halo_px)) + 1};
  // the smallest rectangle of whole pixels around the text
  const double above{style.size_px};
  const double below{0.3 * style.size_px};
  const cv::Rect2d extent{style.upwards ? cv::Rect2d{at.x - above, at.y + before - width, above + below, width}
                                        : cv::Rect2d{at.x - before, at.y - above, width, above + below}};
  const cv::Point corner{static_cast<int>(std::floor(extent.x)) - margin,
                         static_cast<int>(std::floor(extent.y)) - margin};
  const cv::Size size{static_cast<int>(std::ceil(extent.width)) + 2 * margin + 1,
                      static_cast<int>(std::ceil(extent.height)) + 2 * margin + 1};
  std::vector<std::vector<cv::Point>> contours;
  for (Points& contour : text_contours(utf8, style.size_px)) {
    for (cv::Point2d& point : contour) {
      const cv::Point2d along{point.x - before, point.y};
      point = at + (style.upwards ? cv::Point2d{along.y, -along.x} : along) - cv::Point2d{corner};
    }
    contours.push_back(fixed(contour, finer));
  }
  const cv::Rect whole{{0, 0}, parts_.back().size()};
  const cv::Rect shown{cv::Rect{corner, size} & whole};
  if (shown.empty()) return;
  const cv::Rect in_mask{shown.tl() - corner, shown.size()};
  cv::Mat1b fine(size * finer, 0);
  if (style.halo_px > 0) {
    const int thickness{std::max(1, static_cast<int>(std::lround(2 * finer * style.halo_px)))};
    cv::polylines(fine, contours, true, 255, thickness, cv::LINE_8, shift);
    cv::fillPoly(fine, contours, 255, cv::LINE_8, shift);
    blend(parts_.back()(shown), reduced(fine)(in_mask), theme_colour("--card"));
    fine.setTo(0);
  }
  cv::fillPoly(fine, contours, 255, cv::LINE_8, shift);
  blend(parts_.back()(shown), reduced(fine)(in_mask), style.colour);
}

}  // namespace stereogrid::app
