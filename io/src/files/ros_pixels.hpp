// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "stereogrid/io/ros_image.hpp"

namespace stereogrid::io {

/// Pixels in the machine's byte order: of the message, or swapped copies. Throws InputError where the message is
/// smaller than it says.
[[nodiscard]] cv::Mat ros_pixels(const RosImage& image, int type, const std::string& name);

}  // namespace stereogrid::io
