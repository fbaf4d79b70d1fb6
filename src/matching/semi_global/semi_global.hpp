// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clamped_to_int.hpp"
#include "matching/checks/candidates.hpp"
#include "matching/matching.hpp"

namespace stereogrid {

/// Costs and their sums stop here; a label that cannot be taken costs as much.
constexpr int cost_max{255};

/// Cost of leaving a pixel's label on the way to the next one.
struct Penalties {
  int step;       ///< P1: one disparity up or down on an upright surface
  int road_step;  ///< P1 of the road, whose shape is known: else an obstacle's foot passes for a bent road
  int jump;       ///< P2: any other change
  int change;     ///< P_c: between the hypotheses, where an obstacle may stand on the road
};
constexpr Penalties path_penalties{7, 14, 40, 20};
static_assert(path_penalties.jump + census_bits < cost_max,
              "a label that can be taken costs less than one that cannot");

/// Census descriptors of the left image, the right image and the sheared right image.
struct CensusTriple {
  View<const std::uint32_t> left;
  View<const std::uint32_t> right;
  View<const std::uint32_t> sheared;
};

/// Semi-global double correlation (docs/method.md §3.4): the labels (upright, d) and (road, δ) in one optimisation, so
/// that the winning label's type is the class. Pixel cost: Hamming distance of single descriptors. Paths come from the
/// left, the right and below: obstacles stand on the surface below them. Along the path from below, road may turn into
/// upright at the penalty `change` where both have the same disparity ±1. Path costs and sums stop at 255. The output
/// is the best label of each type with the summed cost.
void optimise(Reference& reference, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              CandidateSink& sink);
/// On the CPU it works in `memory`, which grows to optimise_memory() where it is smaller.
void optimise(Cpu& cpu, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              std::vector<std::uint8_t>& memory, std::vector<RowCandidates>& rows, CandidateSink& sink);

std::size_t optimise_memory(int width, int height, const MatchingConfig& config, int threads);

/// True if a row can contain road; other rows have no road label.
STEREOGRID_HD inline bool row_has_road(const RoadPlane& plane, int width, int v) {
  return plane.disparity(0, v) >= 1 || plane.disparity(width - 1, v) >= 1;
}

/// The upright label with the disparity of the first road label; −1 where not all road labels lie among the upright
/// ones, so that nothing can change between them.
STEREOGRID_HD inline int meeting_label(const RoadPlane& plane, Shifts upright, Shifts road, int u, int v) {
  const int meeting{clamped_to_int(std::floor(plane.disparity(u, v) + 0.5)) + road.first};
  return meeting > 0 && meeting + road.count < upright.count ? meeting : -1;
}

}  // namespace stereogrid
