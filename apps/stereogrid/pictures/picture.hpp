// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// A frame at a glance: the left image with what was understood of it, the u-disparity grid below, the filtered grid
/// from above at its side. The size depends on the rig and the grid only.
[[nodiscard]] io::RgbImage draw_picture(const StereoFrame& frame, const FrameResult& result, const Rig& rig);

}  // namespace stereogrid::app
