// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bags/topics.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::app {

/// What the first CameraInfo of each camera says of images of this size, which are rectified where the topics' names
/// say so, or where nothing is left to do. Throws InputError: there is none, or it is not of such a pair.
[[nodiscard]] io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                             int width_px, int height_px);

}  // namespace stereogrid::app
