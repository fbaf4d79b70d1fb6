// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ros2/ros2_topics.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::app {

/// Calibration of the file in the options, else of CameraInfo (and of DisparityImage), which is waited for. Throws
/// InputError: it does not fit the images; depth that does not belong to them.
[[nodiscard]] io::Calibration live_calibration(dds::Node& node, const InputOptions& options, const FoundImages& found);

}  // namespace stereogrid::app
