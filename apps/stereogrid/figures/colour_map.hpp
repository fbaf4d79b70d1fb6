// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "figures/sheet.hpp"
#include "pictures/drawing.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::app::figures {

// Colours of a share in [0, 1].

/// White free, mid grey unknown, black occupied.
[[nodiscard]] Colour occupancy_colour(double share);
/// Dark blue over green to yellow.
[[nodiscard]] Colour sequential_colour(double share);
/// Pale nothing, dark much.
[[nodiscard]] Colour count_colour(double share);

/// For occupancy from 0 to 1.
[[nodiscard]] ColourBar occupancy_bar();
/// For a probability from 0 to 1.
[[nodiscard]] ColourBar probability_bar(const std::string& label);

/// Counts differ by orders of magnitude: a pixel count as a share, logarithmic, 0 for none, 1 for `most`.
[[nodiscard]] double count_share(double count, double most);
[[nodiscard]] ColourBar count_bar(const std::string& label, double most);

/// Shares as colours, enlarged to blocks or reduced by averaging.
[[nodiscard]] cv::Mat map_picture(const Image<float>& shares, int width, int height, Colour (*colour)(double share));

}  // namespace stereogrid::app::figures
