// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "stereogrid/image.hpp"

namespace stereogrid {

/// P(occupied) of rows [begin, end) by all cameras, 0.5 = unknown: see CameraPool. `cells` may be one of `cameras`.
void fuse_camera_rows(std::span<const View<const float>> cameras, int begin, int end, View<float> cells);

}  // namespace stereogrid
