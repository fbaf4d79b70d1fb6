// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "figures/chart.hpp"
#include "figures/colour_map.hpp"

namespace stereogrid::app::figures {
namespace {

constexpr int facets{28};  // along each side

/// Looks from a distance upon the unit cube [0, 1]³: its corner (0, 0) is nearest, x runs to the lower right of the
/// picture and back, y to the lower left and back.
class View3 {
 public:
  // room for the texts: 55 px on both sides, 20 above, 40 below
  View3(int width, int height)
      : centre_{width * 0.5, (height - 20) * 0.5}, scale_{std::min((width - 110) / 1.41, (height - 60) / 1.57)} {}

  [[nodiscard]] cv::Point2d at(double x, double y, double z) const {
    const double right{(x - 0.5) * cos_azimuth - (y - 0.5) * sin_azimuth};
    const double up{(z - 0.5) * cos_elevation + behind(x, y) * sin_elevation};
    return {centre_.x + scale_ * right, centre_.y - scale_ * up};
  }
  /// How far behind the cube's middle.
  [[nodiscard]] static double behind(double x, double y) { return (x - 0.5) * sin_azimuth + (y - 0.5) * cos_azimuth; }

 private:
  static constexpr double sin_azimuth{0.608761};  // 37.5°
  static constexpr double cos_azimuth{0.793353};
  static constexpr double sin_elevation{0.5};  // 30°
  static constexpr double cos_elevation{0.866025};
  cv::Point2d centre_;
  double scale_;
};

struct Facet {
  std::array<cv::Point, 4> corners;
  double height{0};
  double behind{0};
};

std::vector<Facet> facets_of(const Function2& function, const Axis& x, const Axis& y, const View3& view) {
  std::vector<Facet> all;
  const auto value = [&](double s, double t) {
    return function(x.from + s * (x.to - x.from), y.from + t * (y.to - y.from));
  };
  for (int i{0}; i < facets; ++i) {
    for (int j{0}; j < facets; ++j) {
      Facet facet;
      std::size_t k{0};
      for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        const double s{static_cast<double>(i + di) / facets};
        const double t{static_cast<double>(j + dj) / facets};
        const double z{value(s, t)};
        facet.corners[k++] = view.at(s, t, z);
        facet.height += z / 4;
      }
      facet.behind = View3::behind((i + 0.5) / facets, (j + 0.5) / facets);
      all.push_back(facet);
    }
  }
  std::sort(all.begin(), all.end(), [](const Facet& a, const Facet& b) { return a.behind > b.behind; });
  return all;
}

double share_of(const Axis& axis, double value) {
  return (value - axis.from) / (axis.to - axis.from);
}

/// The floor and the two walls behind, with a line at every tick.
void draw_walls(cv::Mat& picture, const View3& view, const Axis& x, const Axis& y, const Axis& z) {
  const cv::Scalar faint{scalar({205, 207, 210})};
  const auto line = [&](cv::Point2d from, cv::Point2d to) { cv::line(picture, from, to, faint, 1, cv::LINE_AA); };
  for (const Tick& tick : x.ticks) {
    const double s{share_of(x, tick.at)};
    line(view.at(s, 0, 0), view.at(s, 1, 0));
    line(view.at(s, 1, 0), view.at(s, 1, 1));
  }
  for (const Tick& tick : y.ticks) {
    const double t{share_of(y, tick.at)};
    line(view.at(0, t, 0), view.at(1, t, 0));
    line(view.at(1, t, 0), view.at(1, t, 1));
  }
  for (const Tick& tick : z.ticks) {
    const double h{share_of(z, tick.at)};
    line(view.at(0, 1, h), view.at(1, 1, h));
    line(view.at(1, 1, h), view.at(1, 0, h));
  }
}

void draw_edges(cv::Mat& picture, const View3& view, const Axis& x, const Axis& y, const Axis& z) {
  const cv::Scalar ink{scalar(palette::ink)};
  cv::line(picture, view.at(0, 0, 0), view.at(1, 0, 0), ink, 1, cv::LINE_AA);
  cv::line(picture, view.at(0, 0, 0), view.at(0, 1, 0), ink, 1, cv::LINE_AA);
  cv::line(picture, view.at(0, 1, 0), view.at(0, 1, 1), ink, 1, cv::LINE_AA);
  const auto text = [&](cv::Point at, const std::string& words, Align align, double size) {
    draw_text(picture, at.x, at.y, words, palette::ink, align, size);
  };
  for (const Tick& tick : x.ticks) {
    text(cv::Point(view.at(share_of(x, tick.at), 0, 0)) + cv::Point{5, 18}, tick.text, Align::left, 0.45);
  }
  for (const Tick& tick : y.ticks) {
    text(cv::Point(view.at(0, share_of(y, tick.at), 0)) + cv::Point{-4, 19}, tick.text, Align::right, 0.45);
  }
  for (const Tick& tick : z.ticks) {
    text(cv::Point(view.at(0, 1, share_of(z, tick.at))) + cv::Point{-7, 2}, tick.text, Align::right, 0.45);
  }
  text(cv::Point(view.at(0.5, 0, 0)) + cv::Point{36, 34}, x.label, Align::left, 0.5);
  text(cv::Point(view.at(0, 0.5, 0)) + cv::Point{-36, 34}, y.label, Align::right, 0.5);
  text(cv::Point(view.at(0, 1, 1)) + cv::Point{0, -12}, z.label, Align::centre, 0.5);
}

}  // namespace

cv::Mat draw_surface(const Function2& function, const Axis& x, const Axis& y, const Axis& z, int width, int height) {
  cv::Mat picture(height, width, CV_8UC3, scalar(palette::paper));
  const View3 view{width, height};
  draw_walls(picture, view, x, y, z);
  const Function2 share = [&](double at_x, double at_y) { return share_of(z, function(at_x, at_y)); };
  for (const Facet& facet : facets_of(share, x, y, view)) {
    const Colour colour{sequential_colour(facet.height)};
    cv::fillConvexPoly(picture, facet.corners.data(), 4, scalar(colour), cv::LINE_AA);
    std::vector<cv::Point> outline(facet.corners.begin(), facet.corners.end());
    cv::polylines(picture, outline, true, scalar(colour) * 0.7, 1, cv::LINE_AA);
  }
  draw_edges(picture, view, x, y, z);
  return picture;
}

}  // namespace stereogrid::app::figures
