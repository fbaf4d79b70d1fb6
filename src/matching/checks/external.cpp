// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/external.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "backend/cpu.hpp"
#include "backend/reference.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{16};
/// Columns that are labelled together, in vectors.
constexpr int tile_columns{64};
/// Height of unusable pixels, px.
constexpr float off_ground{2 * road_margin_px};

/// Input of a frame's labels.
struct SplitInput {
  View<const float> disparity;
  RoadPlane plane;
  HeightTest test;
  Relief<Host> relief;
  int disparities;

  [[nodiscard]] bool is_usable(int u, int v) const { return stereogrid::is_usable(disparity(u, v), disparities); }
};

void put(Matches& matches, int u, int v, const SplitDisparity& parts) {
  matches.obstacle(u, v) = parts.obstacle;
  matches.road(u, v) = parts.road;
}

void split_row(int v, const SplitInput& in, Matches& matches) {
  const GroundRow ground{in.plane, v};
  for (int u{0}; u < in.disparity.width; ++u) {
    const float d{in.disparity(u, v)};
    const bool is_road{in.test.is_on_road(d, ground.at(u), ground.x_of(u))};
    put(matches, u, v, in.is_usable(u, v) ? labelled(d, is_road) : SplitDisparity{0, 0});
  }
}

float height_at(int u, int v, const SplitInput& in) {
  const float d{in.disparity(u, v)};
  return d - GroundRow{in.plane, v}.at(u, d, in.relief);
}

SplitDisparity surface_at(int u, int v, const SplitInput& in) {
  if (!in.is_usable(u, v)) return {0, 0};
  const float d{in.disparity(u, v)};
  const float h{height_at(u, v, in)};
  SurfaceEvidence around;
  for (int j{v - surface_rows}; j <= v + surface_rows; ++j) {
    for (int i{u - surface_columns}; i <= u + surface_columns; ++i) {
      const bool is_other{(i != u || j != v) && i >= 0 && j >= 0 && i < in.disparity.width && j < in.disparity.height};
      if (is_other && in.is_usable(i, j)) around.add(in.disparity(i, j), height_at(i, j, in), d, h);
    }
  }
  return surface_label(d, h, GroundRow{in.plane, v}.x_of(u), around, in.test);
}

void find_heights(int v, const SplitInput& in, Image<float>& heights) {
  const GroundRow ground{in.plane, v};
  float* const row{heights.row(v)};
  for (int u{0}; u < in.disparity.width; ++u) {
    const float d{in.disparity(u, v)};
    row[u] = in.is_usable(u, v) ? d - ground.at(u, d, in.relief) : off_ground;
  }
}

/// Evidence of a tile: that of SurfaceEvidence for each of its columns, in the same order.
struct TileEvidence {
  float sum[tile_columns];
  float pixels[tile_columns];
};

// Adds neighbours begin … end − 1. `other`, `other_heights`: of the neighbour of the first column.
void add_neighbours(const float* other, const float* other_heights, const float* d, const float* h, int begin, int end,
                    float usable_end, TileEvidence& evidence) {
  float sum[tile_columns];  // not in memory that the inputs may share, so that the loop becomes vectors
  float pixels[tile_columns];
  std::copy_n(evidence.sum, tile_columns, sum);
  std::copy_n(evidence.pixels, tile_columns, pixels);
  for (int i{begin}; i < end; ++i) {
    const float upright{other[i] - d[i]};
    const float along{other_heights[i] - h[i]};
    const float term{Min(upright * upright, 1.0f) - Min(along * along, 1.0f)};
    const float seen{other[i] >= 0.5f ? 1.0f : 0.0f};
    const float used{other[i] < usable_end ? seen : 0.0f};
    sum[i] += used > 0 ? term : 0.0f;
    pixels[i] += used;
  }
  std::copy_n(sum, tile_columns, evidence.sum);
  std::copy_n(pixels, tile_columns, evidence.pixels);
}

TileEvidence evidence_of(int first_u, int columns, int v, const SplitInput& in, const Image<float>& heights) {
  TileEvidence evidence{};
  const float usable_end{static_cast<float>(in.disparities) - 0.5f};
  const float* const d{in.disparity.row(v) + first_u};
  const float* const h{heights.row(v) + first_u};
  for (int j{std::max(v - surface_rows, 0)}; j <= std::min(v + surface_rows, in.disparity.height - 1); ++j) {
    for (int i{-surface_columns}; i <= surface_columns; ++i) {
      if (i == 0 && j == v) continue;
      const int begin{std::max(-(first_u + i), 0)};
      const int end{std::min(columns, in.disparity.width - first_u - i)};
      add_neighbours(in.disparity.row(j) + first_u + i, heights.row(j) + first_u + i, d, h, begin, end, usable_end,
                     evidence);
    }
  }
  return evidence;
}

bool is_near_ground(const float* heights, int columns) {
  return std::any_of(heights, heights + columns,
                     [](float h) { return std::abs(h) <= static_cast<float>(road_margin_px); });
}

void split_tile(int first_u, int columns, int v, const SplitInput& in, const Image<float>& heights, Matches& matches) {
  const bool is_near{is_near_ground(heights.row(v) + first_u, columns)};
  const TileEvidence evidence{is_near ? evidence_of(first_u, columns, v, in, heights) : TileEvidence{}};
  const GroundRow ground{in.plane, v};
  for (int i{0}; i < columns; ++i) {
    const int u{first_u + i};
    const SurfaceEvidence around{evidence.sum[i], static_cast<int>(evidence.pixels[i])};
    const SplitDisparity parts{surface_label(in.disparity(u, v), heights(u, v), ground.x_of(u), around, in.test)};
    put(matches, u, v, in.is_usable(u, v) ? parts : SplitDisparity{0, 0});
  }
}

SplitInput input_of(View<const float> disparity, const Rig& rig, const Ground& ground, const Relief<Host>& relief,
                    const MatchingConfig& config) {
  return {disparity, road_plane(rig, ground), HeightTest{rig, ground, config}, relief, config.disparities};
}

}  // namespace

double step_of(View<const float> disparity) {
  constexpr int apart{4};  // rows and columns between the pixels that are looked at
  constexpr double nearly_all{0.95};
  constexpr double steps[]{1, 0.5, 0.25};
  int measured{0};
  int rounded[std::size(steps)]{};
  for (int v{0}; v < disparity.height; v += apart) {
    for (int u{0}; u < disparity.width; u += apart) {
      const double d{disparity(u, v)};
      if (!(d > 0) || !std::isfinite(d)) continue;
      ++measured;
      for (std::size_t i{0}; i < std::size(steps); ++i) rounded[i] += d / steps[i] == std::round(d / steps[i]) ? 1 : 0;
    }
  }
  for (std::size_t i{0}; i < std::size(steps); ++i) {
    if (measured > 0 && rounded[i] >= nearly_all * measured) return steps[i];
  }
  return 0;
}

std::string excess_of(View<const float> disparity, int disparities) {
  constexpr int apart{4};   // rows and columns between the pixels that are looked at
  constexpr int fewest{4};  // a quarter
  int measured{0};
  int beyond{0};
  for (int v{0}; v < disparity.height; v += apart) {
    for (int u{0}; u < disparity.width; u += apart) {
      const float d{disparity(u, v)};
      measured += d > 0 ? 1 : 0;
      beyond += d >= static_cast<float>(disparities) ? 1 : 0;
    }
  }
  if (beyond == 0 || fewest * beyond < measured) return {};
  return std::to_string(100 * beyond / measured) + " % of the disparities are not below matching.disparities (" +
         std::to_string(disparities) +
         ") and are not used. Divide fixed-point disparities by their scale (16 for OpenCV's), or set "
         "matching.disparities to the search range.";
}

void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches) {
  const SplitInput in{input_of(disparity, rig, ground, {}, config)};
  cpu.for_ranges(disparity.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) split_row(v, in, matches);
  });
}

void split(Reference&, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches) {
  const SplitInput in{input_of(disparity, rig, ground, {}, config)};
  for (int v{0}; v < disparity.height; ++v) split_row(v, in, matches);
}

void split_surfaces(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground,
                    const Relief<Host>& relief, const MatchingConfig& config, Image<float>& heights, Matches& matches) {
  const SplitInput in{input_of(disparity, rig, ground, relief, config)};
  cpu.for_ranges(disparity.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) find_heights(v, in, heights);
  });
  cpu.for_ranges(disparity.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) {
      for (int u{0}; u < disparity.width; u += tile_columns) {
        split_tile(u, std::min(tile_columns, disparity.width - u), v, in, heights, matches);
      }
    }
  });
}

void split_surfaces(Reference&, View<const float> disparity, const Rig& rig, const Ground& ground,
                    const Relief<Host>& relief, const MatchingConfig& config, Image<float>&, Matches& matches) {
  const SplitInput in{input_of(disparity, rig, ground, relief, config)};
  for (int v{0}; v < disparity.height; ++v) {
    for (int u{0}; u < disparity.width; ++u) put(matches, u, v, surface_at(u, v, in));
  }
}

}  // namespace stereogrid
