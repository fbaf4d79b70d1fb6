// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"

namespace stereogrid {

MatchingWorkspaceOnDevice::MatchingWorkspaceOnDevice(int width, int height, const MatchingConfig& config)
    : short_census{width, height},
      textured{width, height},
      upright{width, height},
      level{width, height},
      parents{width, height},
      sizes{width, height} {
  const bool has_points{width >= top_step_px && height >= top_window_rows};
  if (has_tops(config) && has_points) tops.emplace_back(top_columns(width), top_row_pairs(height));
  if (has_slices(config)) slices.emplace_back(width, height);
}

void find_candidates(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
                     const RoadPlane* plane, const MatchingConfig& config, MatchingWorkspaceOnDevice& space) {
  describe(cuda, left, right, plane, compared_bits(config.window_px), space.short_census);
  if (has_slices(config)) {
    correlate(cuda, space.short_census, space.slices.front(), config, space.upright.view(), space.level.view());
  } else {
    correlate(cuda, space.short_census, config, space.upright.view(), space.level.view());
  }
}

void match(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
           const RoadPlane* plane, const MatchingConfig& config, MatchingWorkspaceOnDevice& space,
           DeviceMatches& matches) {
  const int least{least_texture(config)};
  if (least > 0) find_texture(cuda, left, config.window_px / 2, least, space.textured.view());
  find_candidates(cuda, left, right, plane, config, space);
  decide(cuda, space.upright.view(), space.level.view(), space.textured.view(), plane, config, matches);
  remove_speckles(cuda, speckle_sizes(config), space.parents.view(), space.sizes.view(), matches);
  for (auto& points : space.tops) {
    add_tops(cuda, space.short_census, plane, top_rules(config), points.view(), matches);
  }
}

namespace {

constexpr int threads{128};

struct MaskedImages {
  View<float, Device> obstacle;
  View<float, Device> road;
  View<float, Device> confidence;
};

// A block clears a row.
__global__ void __launch_bounds__(threads)
    clear_rows(View<const std::uint8_t, Device> masked, int first_row, MaskedImages images) {
  const int v{first_row + static_cast<int>(blockIdx.x)};
  for (int u{static_cast<int>(threadIdx.x)}; u < masked.width; u += threads) {
    if (masked(u, v) != 0) images.obstacle(u, v) = images.road(u, v) = images.confidence(u, v) = 0.0f;
  }
}

}  // namespace

void clear_masked(Cuda& cuda, const PixelMask& mask, View<const std::uint8_t, Device> masked, DeviceMatches& matches) {
  if (mask.empty()) return;
  launch(cuda, clear_rows, dim3{static_cast<unsigned>(mask.end_row() - mask.first_row())}, dim3{threads}, 0, masked,
         mask.first_row(), MaskedImages{matches.obstacle.view(), matches.road.view(), matches.confidence.view()});
}

}  // namespace stereogrid
