// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "backend/cuda.hpp"
#include "geometry/road_plane.hpp"
#include "matching/checks/external.hpp"
#include "matching/checks/mask.hpp"
#include "matching/matching.hpp"

namespace stereogrid {

/// Costs of the best label of one hypothesis at a pixel: a `Candidate` in eight bytes. Its shift is the first shift
/// plus `label`.
struct alignas(8) FoundLabel {
  std::uint16_t cost;
  std::uint16_t before;
  std::uint16_t after;
  std::uint8_t label;
  std::uint8_t has_rivals;
};

/// `Matches` on the device.
struct DeviceMatches {
  DeviceMatches(int width, int height) : obstacle{width, height}, road{width, height}, confidence{width, height} {}

  DeviceImage<float> obstacle;
  DeviceImage<float> road;
  DeviceImage<float> confidence;
};

/// Result of `match` on the device; no pixel has both disparities.
struct MatchViews {
  View<const float, Device> obstacle;
  View<const float, Device> road;
};

/// Short census of the left image, the right image and the right image as the road hypothesis sees it.
struct DescribedOnDevice {
  DescribedOnDevice(int width, int height) : left{width, height}, right{width, height}, sheared{width, height} {}

  DeviceImage<std::uint8_t> left, right, sheared;
};

/// The short census of 32 neighbouring pixels: a word for each bit, the leftmost pixel in its lowest digit.
struct alignas(16) CensusPlanes {
  std::uint32_t bits[short_census_bits];
};

/// The short census of the three images in slices, see correlation/sliced.cu. Words of the left image overlap.
struct SlicedCensus {
  SlicedCensus(int width, int height);

  DeviceImage<CensusPlanes> left, right, sheared;
};

/// Working memory of `match` on the device. Allocated once per pipeline; DeviceError if there is too little memory.
struct MatchingWorkspaceOnDevice {
  MatchingWorkspaceOnDevice(int width, int height, const MatchingConfig& config);

  DescribedOnDevice short_census;
  std::vector<SlicedCensus> slices;    ///< one where has_slices
  DeviceImage<std::uint8_t> textured;  ///< 1 where a window has contrast
  DeviceImage<FoundLabel> upright;
  DeviceImage<FoundLabel> level;
  DeviceImage<int> parents;  ///< speckles: another pixel of the patch; itself where it stands for the patch
  DeviceImage<int> sizes;    ///< pixels, where it stands for a part of a patch
  std::vector<DeviceImage<ThinTop>> tops;  ///< one where has_tops
};

/// As the other back ends do. `plane` lies on the device. All work goes to the stream, without waiting or allocating,
/// so that a graph can be made of it.
void match(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
           const RoadPlane* plane, const MatchingConfig& config, MatchingWorkspaceOnDevice& space,
           DeviceMatches& matches);

/// The candidates alone, to space.upright and space.level. Exposed for tests.
void find_candidates(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
                     const RoadPlane* plane, const MatchingConfig& config, MatchingWorkspaceOnDevice& space);

/// Splits external disparities; `ground` lies on the device. Confidences are unchanged.
void split(Cuda& cuda, View<const float, Device> disparity, const Rig& rig, const Ground* ground,
           const MatchingConfig& config, DeviceMatches& matches);
void split_surfaces(Cuda& cuda, View<const float, Device> disparity, const Rig& rig, const Ground* ground,
                    const Relief<Device>& relief, const MatchingConfig& config, DeviceMatches& matches);

/// PixelMask::clear of all rows; `masked`: its image on the device.
void clear_masked(Cuda& cuda, const PixelMask& mask, View<const std::uint8_t, Device> masked, DeviceMatches& matches);

// The steps of `match`, each in a file of its own.

/// Short census of the three images, of it the `bits` lowest.
void describe(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
              const RoadPlane* plane, int bits, DescribedOnDevice& described);

/// 1 where the window's sum of |L(u+1) − L(u−1)| is at least `least`, else 0.
void find_texture(Cuda& cuda, View<const std::uint8_t, Device> left, int half_window, int least,
                  View<std::uint8_t, Device> textured);

/// Both hypotheses' best labels by windows of the short census.
void correlate(Cuda& cuda, const DescribedOnDevice& census, const MatchingConfig& config,
               View<FoundLabel, Device> upright, View<FoundLabel, Device> level);

/// The same from bit slices, where has_slices; the slices are working memory.
void correlate(Cuda& cuda, const DescribedOnDevice& census, SlicedCensus& slices, const MatchingConfig& config,
               View<FoundLabel, Device> upright, View<FoundLabel, Device> level);
bool has_slices(const MatchingConfig& config);

/// `textured` is not read if config has no texture limit.
void decide(Cuda& cuda, View<const FoundLabel, Device> upright, View<const FoundLabel, Device> level,
            View<const std::uint8_t, Device> textured, const RoadPlane* plane, const MatchingConfig& config,
            DeviceMatches& matches);

/// Speckles::remove.
void remove_speckles(Cuda& cuda, const SpeckleSizes& smallest, View<int, Device> parents, View<int, Device> sizes,
                     DeviceMatches& matches);

/// Replaces matches by thin tops.
void add_tops(Cuda& cuda, const DescribedOnDevice& census, const RoadPlane* plane, const TopRules& rules,
              View<ThinTop, Device> points, DeviceMatches& matches);

}  // namespace stereogrid
