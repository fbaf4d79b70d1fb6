// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "figures/material.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::app::figures {

// The figures of the paper (T-ITS 2012), numbered as there; docs/paper.md tells what each shows.

/// P(O) over visibility and confidence.
[[nodiscard]] io::RgbImage figure_1(const UDisparityConfig& config);
/// The confidences P(C) and P(R), and P(T).
[[nodiscard]] io::RgbImage figure_2(const UDisparityConfig& config);
/// Every stage of a frame, from the image to the grid.
[[nodiscard]] io::RgbImage figure_3(const Material& material);
/// What the Gaussian and the temporal filter do.
[[nodiscard]] io::RgbImage figure_4(const Material& material);
/// The grid beside that of the nearest obstacles.
[[nodiscard]] io::RgbImage figure_6(const Material& material);
/// The result on the camera image, in a few frames.
[[nodiscard]] io::RgbImage figure_7(const Material& material);
/// The influence of P_FP and P_FN.
[[nodiscard]] io::RgbImage figure_8(const Material& material);
/// The grid beside a lidar sweep; nothing where there is none.
[[nodiscard]] std::optional<io::RgbImage> figure_9(const Material& material);

}  // namespace stereogrid::app::figures
