// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::io {

/// OpenCV's matchers, for comparison: StereoBM, and StereoSGBM in MODE_SGBM_3WAY.
enum class OpencvMatcher { block, semi_global };

/// Disparities of a rectified pair of one size by OpenCV (px, 0 = none) with usual settings: block window 21,
/// semi-global block 5, P1 = 8·5·5, P2 = 32·5·5, uniqueness 10 %, speckles under 100 px removed (range 2), left-right
/// difference 1. `disparities` is rounded up to a multiple of 16, as OpenCV requires. OpenCV returns no disparities
/// where the window leaves the image or u is below the number of disparities, and none for images that are too small.
[[nodiscard]] STEREOGRID_EXPORT Image<float> match_with_opencv(OpencvMatcher matcher, const Image<std::uint8_t>& left,
                                                               const Image<std::uint8_t>& right, int disparities);

}  // namespace stereogrid::io
