// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "numbers.hpp"

namespace stereogrid {

/// Half sizes of the short census, and its descriptor's bits.
constexpr int short_census_half_u{3};
constexpr int short_census_half_v{2};
constexpr int short_census_bits{8};

/// Centre-symmetric census of eight pairs in 7 × 5 pixels: a bit is set if a pixel is darker than its mirror image.
/// Gain and offset of the camera do not change it. `pixel(i, j)` is the grey level at column offset i and row offset j.
template <class Pixel>
STEREOGRID_HD inline std::uint8_t short_census(const Pixel& pixel) {
  const auto darker = [&](int i, int j) { return pixel(i, j) < pixel(-i, -j) ? 1u : 0u; };
  return static_cast<std::uint8_t>(darker(-1, 0) | darker(-2, 0) << 1 | darker(-1, -1) << 2 | darker(1, -1) << 3 |
                                   darker(-3, -1) << 4 | darker(3, -1) << 5 | darker(-2, -2) << 6 | darker(2, -2) << 7);
}

/// Bits of the short census that a window of this side compares: a column of differing bits must be countable in a
/// byte.
STEREOGRID_HD inline int compared_bits(int window_px) {
  return 255 / window_px < short_census_bits ? 255 / window_px : short_census_bits;
}

/// Disparity of the road along an image row in fixed point, so that every back end rounds alike.
struct RoadRow {
  std::int32_t start{0};  ///< at u = 0, in 1/65536 px
  std::int32_t slope{0};  ///< per column, in 1/262144 px

  /// In 1/65536 px.
  [[nodiscard]] STEREOGRID_HD std::int32_t at(int u) const { return start + ((slope * u + 2) >> 2); }
  [[nodiscard]] STEREOGRID_HD float disparity_px(int u) const { return static_cast<float>(at(u)) / 65536.0f; }
};

/// Disparities beyond ±16384 px and slopes beyond ±0.25, far from any road, are cut off; columns up to 16384.
STEREOGRID_HD inline RoadRow road_row(const RoadPlane& plane, int v) {
  const auto fixed = [](double value, int limit) {
    return std::int32_t{clamped_to_int(value < 0 ? value - 0.5 : value + 0.5, limit)};
  };
  return {fixed(plane.disparity(0, v) * 65536, 1 << 30), fixed(plane.per_u * 262144, 1 << 16)};
}

/// Grey level of the right image at the road hypothesis for column u: at u − disparity, in 1/256 px, interpolated
/// between its neighbours. `right(column)` is the image row from −1 to `width`, with the border pixel repeated.
template <class Pixel>
STEREOGRID_HD inline std::uint8_t sheared_from(const Pixel& right, int width, int u, const RoadRow& road) {
  const int position{u * 256 - ((road.at(u) + 128) >> 8)};
  const int part{position & 255};
  int below{position >> 8};
  below = below < -1 ? -1 : (below > width - 1 ? width - 1 : below);
  return static_cast<std::uint8_t>((right(below) * (256 - part) + right(below + 1) * part + 128) >> 8);
}
STEREOGRID_HD inline std::uint8_t sheared(const std::uint8_t* right_row, int width, int u, const RoadRow& road) {
  return sheared_from([&](int column) { return right_row[column]; }, width, u, road);
}

/// Best label of one hypothesis at a pixel.
struct Candidate {
  std::uint16_t cost;        ///< cost of the best shift
  std::uint16_t has_rivals;  ///< 1 if a shift more than one step away costs no more than highest_rival, else 0
  std::uint16_t before;      ///< cost one step below the best shift; `cost` where the best is at an end of the range
  std::uint16_t after;       ///< cost one step above it
  std::int16_t shift;        ///< best shift in px

  friend bool operator==(const Candidate&, const Candidate&) = default;
};

/// A match is unique if every shift but its neighbours costs more than this: `cost` itself, and less than the share
/// `uniqueness` above it, given in 1/1024.
STEREOGRID_HD inline int highest_rival(int cost, int uniqueness_1024) {
  const int limit{((cost * (1024 + uniqueness_1024) + 1023) >> 10) - 1};
  return limit > cost ? limit : cost;
}

/// Weights of the winner's costs and disparity in confidence_of.
struct ConfidenceWeights {
  float constant;
  float cost;
  float small_rise;
  float rise;
  float margin;
  float near_disparity;
  float disparity;
};

/// Confidence model of matches up to a maximum cost.
struct ConfidenceModel {
  int cost_limit;            ///< matches with a higher cost are rejected
  int ambiguous_cost_limit;  ///< pixels with a higher cost are not ambiguous
  float per_cost;            ///< 1 / the largest cost
  ConfidenceWeights upright;
  ConfidenceWeights road;
};

// apart, for the vector code's functions of the same names take ConfidenceModel, too
namespace single_numbers {
#include "matching/checks/winner_formulas.hpp"
}  // namespace single_numbers
using single_numbers::subpixel_offset;
using Winner = single_numbers::WinnerOf<int, float, bool>;

/// A Candidate's members as whole numbers.
struct CandidateNumbers {
  int cost;
  int has_rivals;
  int before;
  int after;
  int shift;
};

STEREOGRID_HD inline Winner winner_of(const Candidate& upright, const Candidate& level, std::int32_t road_65536,
                                      int disparities, bool subpixel, const ConfidenceModel& confidences) {
  const auto numbers = [](const Candidate& of) {
    return CandidateNumbers{of.cost, of.has_rivals, of.before, of.after, of.shift};
  };
  const int lead{int{level.cost} - int{upright.cost}};
  const bool is_road{single_numbers::road_counts(road_65536) && lead < 0};
  return single_numbers::winner_of(single_numbers::chosen_of(is_road, numbers(upright), numbers(level)), lead,
                                   road_65536, disparities, subpixel, confidences);
}

/// Columns begin … end − 1.
struct Columns {
  int begin;
  int end;
};

/// Columns of a row where the road counts: none, all, or those up to an end of the row.
inline Columns columns_of_road(const RoadRow& road, int width) {
  const auto counts = [&](int u) { return single_numbers::road_counts(road.at(u)); };
  int low{0};
  for (int high{width}; low < high;) {
    const int middle{(low + high) / 2};
    if (counts(middle) == counts(0)) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return counts(0) ? Columns{0, low} : Columns{low, width};
}

}  // namespace stereogrid
