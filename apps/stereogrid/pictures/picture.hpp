// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Visualisation of a frame: the left image with overlay, the u-disparity grid below, the filtered grid from above at
/// its side. The size depends on the rig and the grid only.
[[nodiscard]] io::RgbImage draw_picture(const StereoFrame& frame, const FrameResult& result, const Rig& rig);

/// The same as SVG: letters and lines are elements, images are embedded.
[[nodiscard]] std::string draw_svg(const StereoFrame& frame, const FrameResult& result, const Rig& rig);

/// Left image of the camera with the same overlay, as JPEG. Needs FrameResult::stages.
[[nodiscard]] std::vector<std::uint8_t> annotated_jpeg(const StereoFrame& frame, const FrameResult& result,
                                                       const Rig& rig);

/// The smoothed u-disparity grid alone, a pixel for each cell, disparities growing downwards, as JPEG. Needs
/// FrameResult::stages.
[[nodiscard]] std::vector<std::uint8_t> u_disparity_jpeg(const FrameResult& result);

}  // namespace stereogrid::app
