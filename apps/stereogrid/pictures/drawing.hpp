// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "pictures/canvas.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Colours of visualisations: those of the page's light theme, and the tints of the camera image.
struct Palette {
  Colour paper{theme_colour("--paper")};
  Colour card{theme_colour("--card")};
  Colour ink{theme_colour("--ink")};
  Colour soft{theme_colour("--soft")};
  Colour free{theme_colour("--cell-free")};
  Colour unknown{theme_colour("--cell-unknown")};
  Colour occupied{theme_colour("--cell-occupied")};
  Colour below{theme_colour("--elevation-below")};
  Colour level{theme_colour("--elevation-level")};
  Colour above{theme_colour("--elevation-above")};
  Colour object{theme_colour("--obstacle-thing")};
  Colour boundary{theme_colour("--obstacle-other")};
  Colour drop{theme_colour("--obstacle-drop")};
  Colour ring{theme_colour("--ring")};
  std::array<Colour, 8> headings;  ///< every 45°, from ahead on, counter-clockwise
  Colour upright{230, 40, 40};
  Colour road{50, 110, 255};

  Palette();
};
[[nodiscard]] const Palette& palette();

/// Between two colours; `share` from 0 to 1.
[[nodiscard]] Colour mix(Colour from, Colour to, double share);
/// Colour of an occupancy: white is free, dark is occupied.
[[nodiscard]] Colour colour_of_occupancy(double occupancy);
/// Colour of an elevation, m: in full from 0.5 m on.
[[nodiscard]] Colour colour_of_elevation(double elevation_m);
/// Colour of a direction in the vehicle's plane (rad, 0 ahead, counter-clockwise). Opposite directions differ under
/// deuteranopia and protanopia, too.
[[nodiscard]] Colour colour_of_direction(double direction_rad);
/// Colour of an obstacle: that of its direction while it moves, else of its kind.
[[nodiscard]] Colour colour_of(const Obstacle& obstacle);
/// Stroke of an obstacle's outline: edges of drops are wide, so that they differ without their colour, too.
[[nodiscard]] Stroke stroke_of(const Obstacle& obstacle);
/// RGB of occupancies, in the order of the image.
[[nodiscard]] cv::Mat occupancy_colours(const Image<float>& occupancy);

constexpr double text_px{16};  ///< size of letters
constexpr double title_px{20};
constexpr double halo_px{2.5};   ///< paper around letters over an image
constexpr double outline_px{2};  ///< width of obstacles' outlines
constexpr double drop_px{4};     ///< width of edges of drops

void fill_box(Canvas& canvas, const Box& box, Colour colour);
void frame_box(Canvas& canvas, const Box& box);
/// Lines readable on any background.
void draw_lines(Canvas& canvas, const std::vector<Points>& lines, const Stroke& stroke);
/// An arrow of one scale: its head has the same size for all lengths that hold it.
void draw_arrow(Canvas& canvas, cv::Point2d from, cv::Point2d to, Colour colour);

/// Numbers of obstacles in a view, and the speed of dynamic ones. Labels that would cover one another are left out.
class Labels {
 public:
  Labels(Canvas& canvas, cv::Size view) : canvas_{canvas}, view_{view} {}

  /// `at`: the middle of the base line.
  void add(const Obstacle& obstacle, cv::Point2d at);

 private:
  Canvas& canvas_;
  cv::Size view_;
  std::vector<cv::Rect2d> covered_;
};

/// Confirmed obstacles, dynamic ones first, then in the order of distance.
[[nodiscard]] std::vector<Obstacle> shown_obstacles(const FrameResult& result);

/// The vehicle frame on the canvas: x up, y to the left. `box` shows the whole grid.
class TopView {
 public:
  TopView(const Box& box, const GridGeometry& grid);

  [[nodiscard]] cv::Point2d at(double x_m, double y_m) const;
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

// Panels of a visualisation. Each fills its box and labels its axes in the margins around it.

constexpr int axis_margin_px{64};  ///< room for the labels on the left and right of a panel
constexpr int axis_below_px{50};   ///< and below the grid
constexpr int legend_height_px{128};
constexpr int legend_width_px{620};

/// A camera's part of a frame.
struct CameraImage {
  const StereoFrame* frame;   ///< nullptr: the camera has no images
  const FrameResult& result;  ///< result of all cameras: grids, obstacles
  const FrameResult& seen;    ///< result of this camera: rigs, ground
  const StageImages& stages;
};
[[nodiscard]] CameraImage image_of(const StereoFrame& frame, const FrameResult& result, int camera);

void draw_camera(Canvas& canvas, const Box& box, const CameraImage& image);
/// Boxes of objects, boundaries as lines with their height, numbers, speeds of dynamic obstacles. `box`: shows the
/// level image.
void draw_obstacles_in_image(Canvas& canvas, const Box& box, const CameraImage& image);
void draw_u_disparity(Canvas& canvas, const Box& box, const CameraImage& image);
void draw_grid(Canvas& canvas, const Box& box, const FrameResult& result);
/// Scales of occupancy and elevation, kinds of lines, wheel of directions.
void draw_grid_legend(Canvas& canvas, const Box& box);

/// Visualisation of a frame: the left image with overlay, the u-disparity grid below, the filtered grid from above at
/// its side. Of several cameras the left images alone, with their names. The size depends on the rigs and the grid
/// only.
[[nodiscard]] io::RgbImage draw_picture(const StereoFrame& frame, const FrameResult& result);

/// The same as SVG: letters and lines are elements, images are embedded.
[[nodiscard]] std::string draw_svg(const StereoFrame& frame, const FrameResult& result);

/// Left image of a camera with the same overlay, as JPEG. Needs FrameResult::stages.
[[nodiscard]] std::vector<std::uint8_t> annotated_jpeg(const CameraImage& image);

/// The smoothed u-disparity grid alone, a pixel for each cell, disparities growing downwards, as JPEG. Needs
/// FrameResult::stages.
[[nodiscard]] std::vector<std::uint8_t> u_disparity_jpeg(const CameraImage& image);

}  // namespace stereogrid::app
