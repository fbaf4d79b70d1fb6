// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "held_bytes.hpp"
#include "matching/checks/candidates.hpp"

namespace stereogrid {

/// Working memory of classify_row.
struct ClassifySpace {
  ClassifySpace() = default;
  explicit ClassifySpace(int width);

  [[nodiscard]] std::size_t held_bytes() const {
    return held_bytes_of(whole, place, rank, labelled, confidence, claims);
  }

  std::vector<std::int16_t> whole;    ///< [u]: Winner::whole
  std::vector<std::uint16_t> place;   ///< [u]: 1 + column of the right image; 0 and width + 1: outside. Then its claim
  std::vector<std::uint32_t> rank;    ///< [u]: cost << 16 | whole; the smallest claim of a place wins
  std::vector<float> labelled;        ///< [u]: Winner::disparity, negative for road; 0: nothing; −0: ambiguous
  std::vector<float> confidence;      ///< [u]: 0 where there is no disparity
  std::vector<std::uint32_t> claims;  ///< [place]: smallest rank; outside: one with a disparity that no pixel has
};

/// One row of `decide`.
struct DecideRow {
  const RowCandidates& candidates;  ///< costs below 32768
  RoadRow road;
  const std::uint8_t* textured;  ///< [u]: 0: too little; readable up to width + 64
  int width;
  int disparities;
  int left_right_px;
  bool subpixel;
  ConfidenceModel confidences;
  float* obstacle;    ///< [u]: result, px, 0: none
  float* on_road;     ///< [u]: result, px, 0: none
  float* confidence;  ///< [u]: result, 0: none
};

/// Label and disparity of a row's pixels: the cheaper hypothesis (winner_of), if its minimum is clear and its window
/// textured, and if no cheaper pixel of the row claims the same place of the right image with another disparity.
void classify_row(const DecideRow& row, ClassifySpace& space);

}  // namespace stereogrid
