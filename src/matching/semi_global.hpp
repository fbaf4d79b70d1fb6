// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "matching/candidates.hpp"
#include "matching/matching.hpp"

namespace stereogrid {

/// Cost of leaving a pixel's label on the way to the next one.
struct Penalties {
  int step;    ///< P1: one disparity up or down within a hypothesis
  int jump;    ///< P2: any other change
  int change;  ///< P_c: to the other hypothesis at the same disparity, ±1
};
Penalties penalties_of(const MatchingConfig& config);

/// What semi-global matching compares: census descriptors of the left image, the right image and the sheared right
/// image.
struct CensusTriple {
  View<const std::uint32_t> left;
  View<const std::uint32_t> right;
  View<const std::uint32_t> sheared;
};

/// Semi-global double correlation (method §1.7): the labels (upright, d) and (road, δ) in one optimisation along four
/// paths (from the left, right, top and bottom), so that the winning label's type is the class. Pixel cost: Hamming
/// distance of single descriptors. The sink gets the best label of each type with the summed cost.
void optimise(Reference& reference, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              CandidateSink& sink);
void optimise(Cpu& cpu, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              std::vector<std::uint8_t>& memory, std::vector<RowCandidates>& rows, CandidateSink& sink);

/// Whole-pixel road disparity, where the two hypotheses meet.
inline int meeting_disparity(const RoadPlane& plane, int u, int v) {
  return static_cast<int>(std::floor(plane.disparity(u, v) + 0.5));
}

}  // namespace stereogrid
