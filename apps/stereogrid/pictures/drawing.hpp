// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/pipeline.hpp"

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

/// The vehicle frame on the canvas: x up, y to the left. `box` shows the whole grid.
class TopView {
 public:
  TopView(const Box& box, const GridGeometry& grid);

  [[nodiscard]] cv::Point at(double x_m, double y_m) const;
  [[nodiscard]] double px_per_m() const { return px_per_m_; }
  [[nodiscard]] double far_m() const { return x_max_m_; }

 private:
  Box box_;
  double x_max_m_;
  double y_max_m_;
  double px_per_m_;
};

/// The multiples of a round step in [from, to].
[[nodiscard]] std::vector<double> ruler_marks(double from_m, double to_m, double length_m);

/// Field of view and distances.
void draw_rulers(cv::Mat& part, const TopView& view, const Rig& rig);

// Panels of a visualisation. Each fills its box and labels its axes in the margins around it.

constexpr int axis_margin_px{44};  ///< room for the labels on the left and right of a panel
constexpr int legend_height_px{84};

void draw_camera(cv::Mat& canvas, const Box& box, const StereoFrame& frame, const FrameResult& result, const Rig& rig);
/// Boxes of objects, boundaries as lines with their height, speeds of dynamic obstacles. `image`: level, with the size
/// of `level_rig`.
void draw_obstacles_in_image(cv::Mat& image, const FrameResult& result, const Rig& level_rig);
void draw_u_disparity(cv::Mat& canvas, const Box& box, const FrameResult& result, const Rig& rig);
void draw_grid(cv::Mat& canvas, const Box& box, const FrameResult& result, const Rig& rig);
/// Shades of occupancy and colours of motion.
void draw_grid_legend(cv::Mat& canvas, const Box& box);

}  // namespace stereogrid::app
