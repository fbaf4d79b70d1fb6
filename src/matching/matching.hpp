// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "ground/model.hpp"
#include "matching/model.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// What `match` leaves: two disparity images (px, 0 = none); no pixel has both.
struct Matches {
  Matches(int width, int height) : obstacle{width, height}, road{width, height} {}

  Image<float> obstacle;
  Image<float> road;
};

/// A range of shifts to search: first … first + count − 1.
struct Shifts {
  int first{0};
  int count{0};
};

/// What `match` works in. Allocated once per pipeline.
struct MatchingSpace {
  MatchingSpace(int width, int height);

  Image<std::uint8_t> sheared_right;
  Image<std::uint32_t> census_left, census_right, census_sheared;
  Image<Candidate> upright, level;
  Image<std::uint8_t> textured;
  Image<int> patch;                  ///< speckle removal: union-find over pixels
  std::vector<std::uint8_t> memory;  ///< CPU: working memory of the bands
};

/// Double correlation (T-ITS 2012, III-C): every pixel is matched as part of an upright surface (constant disparity in
/// the window) and of the road (disparity of the plane, window sheared along). The cheaper hypothesis gives label and
/// disparity, if it passes the texture, uniqueness and left-right tests. Cost: Hamming distance of centre-symmetric
/// census, summed over the window; outside the image the border is repeated.
void match(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingSpace& space, Matches& matches);
void match(Reference& reference, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingSpace& space, Matches& matches);

/// Matches `left` against `right` with fronto-parallel windows over `shifts` (left u against right u − shift).
/// Exposed for tests; images are census descriptors.
void correlate(Reference& reference, View<const std::uint32_t> left, View<const std::uint32_t> right, Shifts shifts,
               const MatchingConfig& config, View<Candidate> candidates);
void correlate(Cpu& cpu, View<const std::uint32_t> left, View<const std::uint32_t> right, Shifts shifts,
               const MatchingConfig& config, std::vector<std::uint8_t>& memory, View<Candidate> candidates);

/// The shifts of the two hypotheses.
Shifts upright_shifts(const MatchingConfig& config);
Shifts road_shifts(const MatchingConfig& config);

/// Label and disparity of one pixel from its two candidates, by the test that the doc comment of `match` names.
void decide_row(int v, const RoadPlane& plane, const MatchingConfig& config, const MatchingSpace& space,
                Matches& matches);

/// Removes connected patches (neighbours of the same label, disparities within 1 px) of fewer than `speckle_px` pixels.
void remove_speckles(int speckle_px, Image<int>& patch, Matches& matches);

}  // namespace stereogrid
