// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pictures/panels.hpp"
#include "stereogrid/level_mapping.hpp"

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

/// The left image (grey) as the stages saw it.
cv::Mat level_image(const StereoFrame& frame, const Rig& rig) {
  const Image<std::uint8_t>& left{frame.left};
  cv::Mat grey(left.height(), left.width(), CV_8UC1);
  std::copy(left.begin(), left.end(), grey.begin<std::uint8_t>());
  const LevelMapping mapping{rig};
  if (mapping.is_identity()) return grey;
  const Rig& level_rig{mapping.level_rig()};
  const double c{std::cos(rig.camera_pitch_rad)};
  const double s{std::sin(rig.camera_pitch_rad)};
  const cv::Matx33d camera{rig.focal_px, 0, rig.centre_u_px, 0, rig.focal_px, rig.centre_v_px, 0, 0, 1};
  const cv::Matx33d level_camera{rig.focal_px, 0, rig.centre_u_px, 0, rig.focal_px, level_rig.centre_v_px, 0, 0, 1};
  const cv::Matx33d pitched_from_level{1, 0, 0, 0, c, -s, 0, s, c};
  cv::Mat level;
  cv::warpPerspective(grey, level, camera * pitched_from_level * level_camera.inv(),
                      {level_rig.width_px, level_rig.height_px}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  return level;
}

}  // namespace

void draw_camera(cv::Mat& canvas, const Box& box, const StereoFrame& frame, const FrameResult& result, const Rig& rig) {
  const StageImages& stages{result.stages};
  cv::Mat colour;
  cv::cvtColor(level_image(frame, rig), colour, cv::COLOR_GRAY2RGB);
  for (int v{0}; v < colour.rows; ++v) {
    for (int u{0}; u < colour.cols; ++u) {
      const float obstacle{stages.obstacle_disparity(u, v)};
      const float road{stages.road_disparity(u, v)};
      cv::Vec3b& pixel{colour.at<cv::Vec3b>(v, u)};
      if (obstacle > 0 && occupancy_at(stages, u, obstacle) > upright_above) {
        blend(pixel, palette::upright);
      } else if (road > 0 && occupancy_at(stages, u, road) < free_below) {
        blend(pixel, palette::road);
      }
    }
  }
  draw_obstacles_in_image(colour, result, LevelMapping{rig}.level_rig());
  cv::Mat part{canvas(cv::Rect{box.x, box.y, box.width, box.height})};
  cv::resize(colour, part, part.size(), 0, 0, box.width < colour.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
  frame_box(canvas, box);
}

}  // namespace stereogrid::app
