// SPDX-License-Identifier: Apache-2.0
//
// Stands in for the few functions of the vector code that the host, the reference back end or its memory call.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ground/plane_evidence.hpp"
#include "images/patch.hpp"
#include "matching/checks/simd.hpp"
#include "matching/correlation/simd.hpp"
#include "obstacles/segmentation/columns.hpp"
#include "terrain/polar_places.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

// Only the CPU back end works in these.
TextureWorkspace::TextureWorkspace(int /*width*/, int /*half_window*/) {}
ClassifyWorkspace::ClassifyWorkspace(int /*width*/) {}
int correlate_border(Shifts upright) {
  return std::max(upright.count, road_shifts.count) + 128;
}

void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   SurfaceBits& bits) {
  for (auto* words : {&bits.is_measured, &bits.continues_left, &bits.continues_above}) {
    std::fill(words->begin(), words->end(), 0);
  }
  for (int u{0}; u < width; ++u) labelled[u] = obstacle[u] - road[u];
  for (int u{0}; u < width; ++u) {
    const float here{labelled[u]};
    const auto continues = [&](float neighbour) {
      return std::abs(here - neighbour) <= 1.0f && here * neighbour > 0;  // signs are labels
    };
    const auto set = [&](std::vector<std::uint64_t>& words, bool bit) {
      words[static_cast<std::size_t>(u) / 64] |= static_cast<std::uint64_t>(bit) << u % 64;
    };
    set(bits.is_measured, here != 0);
    set(bits.continues_left, continues(labelled[u - 1]));
    set(bits.continues_above, continues(above[u]));
  }
}

bool cut(View<const std::uint8_t> image, Place place, float shear, Template& patch) {
  return plain::cut(image, place, shear, patch);
}
std::optional<Place> find(View<const std::uint8_t> image, const Template& patch, float shear, Place start,
                          FindLimits limits) {
  return plain::find(image, patch, shear, start, limits);
}

void smooth_rows(View<const std::uint8_t> image, int begin, int end, View<std::uint8_t> smoothed) {
  for (int v{begin}; v < end; ++v) {
    for (int u{0}; u < image.width; ++u) {
      int sum{8};
      for (int j{-1}; j <= 1; ++j) {
        for (int i{-1}; i <= 1; ++i) {
          const int grey{image(std::clamp(u + i, 0, image.width - 1), std::clamp(v + j, 0, image.height - 1))};
          sum += grey * (2 - std::abs(i)) * (2 - std::abs(j));
        }
      }
      smoothed(u, v) = static_cast<std::uint8_t>(sum / 16);
    }
  }
}

PlaneSums<support_sums> sum_support(const PlaneHypothesis& plane, const PlaneSamples& samples) {
  return plain::sum_support(plane, samples);
}
PlaneSums<equation_sums> sum_equations(const PlaneHypothesis& plane, const PlaneSamples& samples,
                                       std::span<const float> weights) {
  return plain::sum_equations(plane, samples, weights);
}

void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels) {
  plain::find_upright(row, width, begin, end, limits, pixels);
}

void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians) {
  plain::find_medians(obstacle, road, column, rows, medians);
}

void find_places(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy,
                 PolarPlaces& places) {
  for (std::size_t i{0}; i < PolarPlaces::size; ++i, ix += step) {
    places.x[i] = cells.x_of(ix, iy);
    const PolarPlace place{polar_place(geometry, places.x[i], cells.y_of(ix, iy))};
    places.ring[i] = place.ring;
    places.first[i] = place.first;
    places.last[i] = place.last;
  }
}

}  // namespace stereogrid
