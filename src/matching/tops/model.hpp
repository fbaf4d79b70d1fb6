// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "geometry/matches.hpp"
#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "matching/model.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Thin tops: things above the road of a few rows and many columns, such as tops of tables and beams across the way.
/// They are searched on a lattice of points, with a window of two rows and fifteen columns of the lattice. Its columns
/// are four pixels apart because the census of neighbouring pixels says almost the same.
constexpr int top_step_px{4};
constexpr int top_window_rows{2};
constexpr int top_half_columns{7};
constexpr int top_samples{top_window_rows * (2 * top_half_columns + 1)};

// Chosen on the random layouts 14, 34, 439 and the rendered street C.
constexpr int top_run{8};           ///< neighbouring points with one disparity that a top has at least
constexpr int top_beyond_rows{6};   ///< this far above and below nothing is matched at its disparity: windows see it
constexpr int top_lead_px{2};       ///< by which its disparity exceeds what it replaces, and that of the matches beyond
constexpr int top_over_road_px{3};  ///< as far as the road hypothesis searches
constexpr int top_uniqueness_1024{51};
constexpr int top_disparities_max{256};

/// A top at a point of the lattice.
struct ThinTop {
  float disparity;  ///< px; 0: none
  float confidence;
};

/// Points along an axis. The first pixel of point i's block is i times the step.
STEREOGRID_HD inline int top_columns(int width) {
  return width / top_step_px;
}
STEREOGRID_HD inline int top_row_pairs(int height) {
  return height / top_window_rows;
}

/// The pixel column of a point; beyond the ends that of the last one.
STEREOGRID_HD inline int top_pixel(int point, int points) {
  const int within{point < 0 ? 0 : (point < points ? point : points - 1)};
  return within * top_step_px + top_step_px / 2;
}

/// Decides about the points, besides images.
struct TopRules {
  ConfidenceModel confidences;
  int disparities;
  int cost_limit;     ///< costs of a top's window are at most this
  int window_pixels;  ///< size of the upright window, for whose costs the confidences are
  bool subpixel;
};

/// The road in a row and the next one.
struct TopRoad {
  STEREOGRID_HD TopRoad(const RoadPlane& plane, int v) : here{road_row(plane, v)}, below{road_row(plane, v + 1)} {}

  RoadRow here;
  RoadRow below;
};

/// Whether a disparity may be a top's at a point: higher over the road than the road's hypothesis reaches, and so near
/// that the window is narrower than the camera is high.
STEREOGRID_HD inline bool may_be_top(const TopRoad& road, int u, int disparity) {
  const std::int32_t road_65536{road.here.at(u)};
  const std::int64_t per_row_65536{std::int64_t{road.below.at(u)} - road_65536};
  constexpr int window_px{top_step_px * (2 * top_half_columns + 1)};
  const std::int64_t found_65536{std::int64_t{disparity} * 65536};
  return single_numbers::road_counts(road_65536) && found_65536 - road_65536 >= top_over_road_px * 65536 &&
         found_65536 >= window_px * per_row_65536;
}

/// The first of the least costs.
STEREOGRID_HD inline int cheapest(const std::uint8_t* costs, int disparities) {
  int best{0};
  for (int d{1}; d < disparities; ++d) best = costs[d] < costs[best] ? d : best;
  return best;
}

/// The top at a point of the lattice, from the costs of its disparities and the cheapest one. `nearest(v)`: disparity
/// matched in row v at its column u, repeated beyond the image.
template <class Nearest>
STEREOGRID_HD inline ThinTop top_of(const std::uint8_t* costs, int best, const TopRules& rules, const TopRoad& road,
                                    int u, int v, const Nearest& nearest) {
  constexpr ThinTop none{0, 0};
  if (best == 0 || best + 1 >= rules.disparities || best > u || !may_be_top(road, u, best)) return none;
  const int least{costs[best]};
  if (least > rules.cost_limit) return none;
  const int rival{highest_rival(least, top_uniqueness_1024)};
  int as_cheap{0};
  for (int d{0}; d < rules.disparities; ++d) as_cheap += costs[d] <= rival ? 1 : 0;
  const int before{costs[best - 1]};
  const int after{costs[best + 1]};
  if (as_cheap > 1 + (before <= rival ? 1 : 0) + (after <= rival ? 1 : 0)) return none;
  const auto beyond = static_cast<float>(best - top_lead_px);
  if (nearest(v - top_beyond_rows) > beyond || nearest(v + top_window_rows - 1 + top_beyond_rows) > beyond) return none;
  const float offset{rules.subpixel ? subpixel_offset(before, least, after) : 0.0f};
  const float disparity{static_cast<float>(best) + offset};
  const auto in_window = [&](int cost) { return cost * rules.window_pixels / top_samples; };
  const int rise{(before < after ? before : after) - least};
  return {disparity, single_numbers::confidence_of(single_numbers::evidence_of(
                         rules.confidences, false, in_window(least), in_window(rise), 0, disparity))};
}

/// Whether a point belongs to a run of tops. `row`: the lattice's.
STEREOGRID_HD inline bool is_in_top(const ThinTop* row, int points, int point) {
  const auto joined = [&](int a) {  // points a and a + 1
    const float difference{row[a].disparity - row[a + 1].disparity};
    return row[a].disparity > 0 && row[a + 1].disparity > 0 && difference <= 1.0f && difference >= -1.0f;
  };
  if (!(row[point].disparity > 0)) return false;
  int first{point};
  while (first > 0 && point - first < top_run && joined(first - 1)) --first;
  int last{point};
  while (last + 1 < points && last - first + 1 < top_run && joined(last)) ++last;
  return last - first + 1 >= top_run;
}

/// Replaces the match of a pixel that shows the top in it.
STEREOGRID_HD inline void put_top(const ThinTop& top, float& obstacle, float& road, float& confidence) {
  const float matched{obstacle > road ? obstacle : road};
  if (matched > top.disparity - static_cast<float>(top_lead_px)) return;
  obstacle = top.disparity;
  road = 0;
  confidence = top.confidence;
}

}  // namespace stereogrid
