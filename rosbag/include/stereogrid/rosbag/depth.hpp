// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "stereogrid/image.hpp"
#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::rosbag {

/// Decodes depth to metres along the camera's axis; 0 = none. `topic`: of the message. sensor_msgs/Image: 16UC1 in mm,
/// 32FC1 in m (REP 118); CompressedImage: PNG of 16 bits in mm, or what compressed_depth_image_transport writes (PNG or
/// RVL of 16UC1 and 32FC1); stereo_msgs/DisparityImage: f·T/d. NaN, infinity and values outside the message's own
/// limits are none. Throws InputError: damaged, or of an encoding that is not read.
[[nodiscard]] Image<float> decode_depth(std::span<const std::byte> cdr, const mcap::Topic& topic,
                                        const std::string& name);

/// T of a DisparityImage, m; 0: it has none. Throws InputError: damaged.
[[nodiscard]] double disparity_baseline_m(std::span<const std::byte> cdr);
/// T of the first DisparityImage of a topic, m; 0: it has none.
[[nodiscard]] double first_baseline_m(const mcap::Bag& bag, const std::string& topic);

/// Repeats or leaves out pixels to the size of the image. Throws InputError where the ratios of both sides differ.
[[nodiscard]] Image<float> fit_depth(Image<float> depth_m, int width_px, int height_px, const std::string& name);

}  // namespace stereogrid::rosbag
