// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pictures/drawing.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/level_mapping.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::app {
namespace {

// The paper's overlay, on P(T) before the Gaussian: a wall one bin deep hardly reaches 0.75 after it.
constexpr float upright_above{0.75F};
constexpr float free_below{0.4F};
constexpr double tint{0.5};

void blend(cv::Vec3b& pixel, Colour colour) {
  const double target[3]{double(colour.red), double(colour.green), double(colour.blue)};
  for (int i{0}; i < 3; ++i) pixel[i] = static_cast<std::uint8_t>((1 - tint) * pixel[i] + tint * target[i]);
}

/// P of the u-disparity bin that a pixel falls into; 0.5 where it has none.
float occupancy_at(const StageImages& stages, int u, float disparity) {
  const int bin{static_cast<int>(std::lround(disparity))};
  return bin > 0 && bin < stages.occupancy.height() ? stages.occupancy(u, bin) : 0.5F;
}

/// The left image; black where the camera has none.
cv::Mat grey_image(const CameraImage& image) {
  const Rig& rig{image.seen.rig};
  if (image.frame == nullptr || image.frame->left.empty()) return cv::Mat::zeros(rig.height_px, rig.width_px, CV_8UC1);
  const Image<std::uint8_t>& left{image.frame->left};
  cv::Mat grey(left.height(), left.width(), CV_8UC1);
  std::copy(left.begin(), left.end(), grey.begin<std::uint8_t>());
  return grey;
}

cv::Matx33d camera_from_level(const Rig& rig, const Rig& level_rig) {
  const double c{std::cos(rig.camera_pitch_rad)};
  const double s{std::sin(rig.camera_pitch_rad)};
  const cv::Matx33d camera{rig.focal_px, 0, rig.cx_px, 0, rig.focal_px, rig.cy_px, 0, 0, 1};
  const cv::Matx33d level_camera{rig.focal_px, 0, rig.cx_px, 0, rig.focal_px, level_rig.cy_px, 0, 0, 1};
  const cv::Matx33d pitched_from_level{1, 0, 0, 0, c, -s, 0, s, c};
  return camera * pitched_from_level * level_camera.inv();
}

/// The left image (grey) as the stages saw it.
cv::Mat level_image(const CameraImage& image) {
  const Rig& rig{image.seen.rig};
  const cv::Mat grey{grey_image(image)};
  const LevelMapping mapping{rig};
  if (mapping.is_identity()) return grey;
  const Rig& level_rig{mapping.level_rig()};
  cv::Mat level;
  cv::warpPerspective(grey, level, camera_from_level(rig, level_rig), {level_rig.width_px, level_rig.height_px},
                      cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  return level;
}

constexpr std::uint8_t nothing{0};
constexpr std::uint8_t upright{1};
constexpr std::uint8_t road{2};

/// Behind an edge: no road, though the ground there may be visible.
bool is_behind_edge(const FrameResult& result, const Rig& level_rig, int u, float disparity) {
  const double x_m{level_rig.focal_px * level_rig.baseline_m / disparity};
  const double y_m{(level_rig.cx_px - u) * x_m / level_rig.focal_px};
  const auto cell = result.vehicle.geometry.cell_at(camera_place(level_rig) * Point2{x_m, y_m});
  if (!cell || result.terrain.empty()) return false;
  const TerrainClass kind{result.terrain(cell->ix, cell->iy)};
  return kind == TerrainClass::drop || kind == TerrainClass::hidden;
}

/// Class of each pixel according to the stages.
cv::Mat1b classes_of(const CameraImage& image, const Rig& level_rig) {
  const StageImages& stages{image.stages};
  const Image<float>& obstacles{stages.obstacle_disparity};
  cv::Mat1b kinds(obstacles.height(), obstacles.width(), nothing);
  for (int v{0}; v < kinds.rows; ++v) {
    for (int u{0}; u < kinds.cols; ++u) {
      const float of_obstacle{obstacles(u, v)};
      const float of_road{stages.road_disparity(u, v)};
      if (of_obstacle > 0 && occupancy_at(stages, u, of_obstacle) > upright_above) {
        kinds(v, u) = upright;
      } else if (of_road > 0 && occupancy_at(stages, u, of_road) < free_below &&
                 !is_behind_edge(image.result, level_rig, u, of_road)) {
        kinds(v, u) = road;
      }
    }
  }
  return kinds;
}

cv::Mat tinted(const cv::Mat& grey, const cv::Mat1b& kinds) {
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2RGB);
  for (int v{0}; v < colour.rows; ++v) {
    for (int u{0}; u < colour.cols; ++u) {
      const std::uint8_t kind{kinds(v, u)};
      if (kind != nothing) blend(colour.at<cv::Vec3b>(v, u), kind == upright ? palette().upright : palette().road);
    }
  }
  return colour;
}

}  // namespace

CameraImage image_of(const StereoFrame& frame, const FrameResult& result, int camera) {
  if (result.cameras.empty()) return {&frame, result, result, result.stages};
  const FrameResult& seen{result.cameras.at(static_cast<std::size_t>(camera))};
  return {seen.has_images ? frame_of(frame, camera) : nullptr, result, seen, camera == 0 ? result.stages : seen.stages};
}

void draw_camera(Canvas& canvas, const Box& box, const CameraImage& image) {
  const Rig level_rig{LevelMapping{image.seen.rig}.level_rig()};
  canvas.image(box, tinted(level_image(image), classes_of(image, level_rig)), true);
  if (image.frame != nullptr) draw_obstacles_in_image(canvas, box, image);
  frame_box(canvas, box);
}

std::vector<std::uint8_t> annotated_jpeg(const CameraImage& image) {
  constexpr int quality{80};
  const cv::Mat grey{grey_image(image)};
  const LevelMapping mapping{image.seen.rig};
  cv::Mat1b kinds{classes_of(image, mapping.level_rig())};
  if (!mapping.is_identity()) {
    cv::Mat1b of_camera;
    cv::warpPerspective(kinds, of_camera, camera_from_level(image.seen.rig, mapping.level_rig()), grey.size(),
                        cv::INTER_NEAREST);
    kinds = of_camera;
  }
  cv::Mat colour{tinted(grey, kinds)};
  cv::cvtColor(colour, colour, cv::COLOR_RGB2BGR);
  return io::encode_jpeg(view_of(colour), quality);
}

}  // namespace stereogrid::app
