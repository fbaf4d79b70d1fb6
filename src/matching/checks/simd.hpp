// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matching/checks/candidates.hpp"
#include "matching/padded.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// Working memory of classify_row.
struct ClassifyWorkspace {
  ClassifyWorkspace() = default;
  explicit ClassifyWorkspace(int width);

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(lead, place, rank, labelled, evidence, unmatched, obstacle, on_road, confidence, claims);
  }

  std::vector<std::int16_t> lead;    ///< [u]: cost of the road hypothesis less that of the upright one
  std::vector<std::uint32_t> place;  ///< [u]: 1 + column of the right image; 0 and width + 1: outside. Then its claim
  std::vector<std::uint32_t> rank;   ///< [u]: cost << 16 | whole; the smallest claim of a place wins
  std::vector<float> labelled;       ///< [u]: Winner::disparity, negative for road; 0: nothing
  std::vector<float> evidence;       ///< [u]: Winner::evidence
  std::vector<float> unmatched;      ///< [u]: obstacle disparity if the pixel has no match: ambiguous_px or 0
  std::vector<float> obstacle;       ///< [u]: results, where a whole vector has no room in the row
  std::vector<float> on_road;
  std::vector<float> confidence;
  std::vector<std::uint32_t> claims;  ///< [place]: smallest rank; outside: one with a disparity that no pixel has
};

/// One row of `decide`.
struct DecideRow {
  RowCandidates& candidates;  ///< costs below 32768; upright ones become the chosen ones
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
void classify_row(const DecideRow& row, ClassifyWorkspace& space);

/// Working memory of texture_rows.
struct TextureWorkspace {
  TextureWorkspace() = default;
  TextureWorkspace(int width, int half_window);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(columns, fours); }

  std::vector<std::uint16_t> columns;  ///< [half_window + u]: contrast summed over the window's rows
  std::vector<std::int32_t> fours;     ///< [u]: sums of four columns
};

/// textured = 1 where the window's sum of |L(u+1) − L(u−1)| is at least `least`, else 0, for the rows begin … end − 1;
/// the border is repeated.
void texture_rows(const Padded<std::uint8_t>& left, int half_window, std::int32_t least, int begin, int end,
                  TextureWorkspace& space, Padded<std::uint8_t>& textured);

/// Relations of the pixels of a row to their neighbours, a bit each, pixel 0's the lowest of the first word. Words
/// cover pixel `width`, too, which none continues.
struct SurfaceBits {
  std::vector<std::uint64_t> is_measured;      ///< there is a disparity
  std::vector<std::uint64_t> continues_left;   ///< same label as the pixel before, disparities within 1 px
  std::vector<std::uint64_t> continues_above;  ///< likewise with the pixel above
};

/// Joins a row's two disparity images (px, 0 = none) in `labelled`: obstacle disparity, minus road disparity, or 0.
/// Finds neighbours on one surface. `labelled` and `above`, the row above in the same form, begin with a 0 before the
/// row and end with 64 zeros.
void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   SurfaceBits& bits);

}  // namespace stereogrid
