// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::research {

struct NamedGrid {
  std::string name;
  std::string title;
  Image<float> occupancy;
};

/// The camera image, and below it the truth and every method's grid from above: white free, black occupied, grey
/// unknown; in the truth grey is not scored and red is a partly hidden obstacle.
[[nodiscard]] io::RgbImage draw_comparison(const Image<std::uint8_t>& left, const evaluation::Labels& labels,
                                           const std::vector<NamedGrid>& grids);

}  // namespace stereogrid::research
