// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Stands in for the few functions of the vector code that the host, the reference back end or its memory call.
#include <algorithm>
#include <cmath>

#include "images/patch.hpp"
#include "matching/checks/classify_simd.hpp"
#include "matching/checks/texture_simd.hpp"
#include "matching/correlation/correlate_simd.hpp"
#include "matching/surfaces_simd.hpp"
#include "obstacles/segmentation/upright_row.hpp"
#include "plain_places.hpp"
#include "terrain/medians.hpp"

namespace stereogrid {

// Only the CPU back end works in these.
TextureSpace::TextureSpace(int /*width*/, int /*half_window*/) {}
ClassifySpace::ClassifySpace(int /*width*/) {}
int correlate_border(Shifts upright) {
  return std::max(upright.count, road_shifts.count) + 128;
}

void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   std::uint8_t* flags) {
  for (int u{0}; u < width; ++u) labelled[u] = obstacle[u] - road[u];
  for (int u{0}; u < width; ++u) {
    const float here{labelled[u]};
    const auto continues = [&](float neighbour) {
      return std::abs(here - neighbour) <= 1.0f && here * neighbour > 0;  // signs are labels
    };
    flags[u] =
        static_cast<std::uint8_t>((here != 0 ? is_measured : 0) | (continues(labelled[u - 1]) ? continues_left : 0) |
                                  (continues(above[u]) ? continues_above : 0));
  }
}

bool cut(View<const std::uint8_t> image, Place place, float shear, Template& patch) {
  return plain::cut(image, place, shear, patch);
}
std::optional<Place> find(View<const std::uint8_t> image, const Template& patch, float shear, Place start,
                          FindLimits limits) {
  return plain::find(image, patch, shear, start, limits);
}

void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels) {
  plain::find_upright(row, width, begin, end, limits, pixels);
}

void find_medians(View<const float> obstacle, View<const float> road, int column, RowRange rows, float* medians) {
  plain::find_medians(obstacle, road, column, rows, medians);
}

void find_places(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy,
                 PolarPlaces& places) {
  places = test::plain_places(geometry, cells, ix, step, iy);
}

}  // namespace stereogrid
