// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pictures/drawing.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

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
