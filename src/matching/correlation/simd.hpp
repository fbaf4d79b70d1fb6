// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "matching/checks/candidates.hpp"
#include "matching/matching.hpp"
#include "matching/model.hpp"
#include "matching/padded.hpp"

namespace stereogrid {

/// Elements that the functions below read or write beyond a row's ends.
constexpr int row_overrun{64 + short_census_half_u};

/// Descriptors of a row, equal to the `bits` lowest of `short_census`. `window` are the image rows v −
/// short_census_half_v … v + short_census_half_v.
void short_census_row(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out);

/// The same from right to left.
void short_census_reversed(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out);

/// A row of the right image as the road hypothesis sees it, equal to `sheared`.
void shear_row(const std::uint8_t* right_row, int width, const RoadRow& road, std::uint8_t* out);

/// Short census of the images that `correlate` compares.
struct ShortCensus {
  const Padded<std::uint8_t>& left;
  const Padded<std::uint8_t>& right_reversed;  ///< each row from right to left: a left pixel's shifts lie in a row
  const Padded<std::uint8_t>& sheared;
};

/// One band of rows of `correlate`.
struct Band {
  ShortCensus census;
  Shifts upright;
  int half_window{0};
  int uniqueness_1024{0};
  int cost_limit{0};
  const RoadPlane& plane;
  int first_row{0};
  int end_row{0};
  std::uint8_t* memory{nullptr};  ///< correlate_memory() bytes, 64-byte aligned
  RowCandidates* candidates{nullptr};
  CandidateSink* sink{nullptr};
};

/// Upright shifts with padding: each parity in words of 32 bits.
inline int padded_upright(Shifts shifts) {
  return (shifts.count + 63) / 64 * 64;
}

/// Bytes that a band works in, whatever the instruction set.
std::size_t correlate_memory(int width, Shifts upright, int half_window);

/// Elements beyond the ends of the rows of `ShortCensus` that are read, whatever the instruction set.
int correlate_border(Shifts upright);

/// Writes the candidates of the band's rows; members that find_candidates sets equal the reference on every instruction
/// set.
void correlate_band(const Band& band);

/// Name of the instruction set that correlate_band uses on this machine; "SCALAR": it cannot work.
std::string_view correlate_target();

}  // namespace stereogrid
