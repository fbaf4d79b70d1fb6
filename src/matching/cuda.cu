// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"

namespace stereogrid {

MatchingWorkspaceOnDevice::MatchingWorkspaceOnDevice(int width, int height, const MatchingConfig& config)
    : textured{width, height},
      upright{width, height},
      level{width, height},
      parents{width, height},
      sizes{width, height} {
  if (config.method == MatchingMethod::semi_global) {
    semi_global.emplace_back(width, height, config);
  } else {
    short_census.emplace_back(width, height);
  }
}

void find_candidates(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
                     const RoadPlane* plane, const MatchingConfig& config, MatchingWorkspaceOnDevice& space) {
  if (config.method == MatchingMethod::semi_global) {
    SemiGlobalOnDevice& room{space.semi_global.front()};
    describe(cuda, left, right, plane, room.census);
    optimise(cuda, room, plane, config, space.upright.view(), space.level.view());
  } else {
    DescribedOnDevice<std::uint8_t>& described{space.short_census.front()};
    describe(cuda, left, right, plane, compared_bits(config.window_px), described);
    correlate(cuda, described, config, space.upright.view(), space.level.view());
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
}

}  // namespace stereogrid
