// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/columns.hpp"

#include <array>
#include <bit>
#include <cmath>

#include "clamped_to_int.hpp"

namespace stereogrid {

/// Obstacle pixels of a row and their bins of the u-disparity plane.
struct BinnedPixels : UprightPixels {
  std::array<int, most> bins;
  std::array<int, most> between;  ///< 1 below the height of obstacles, else 0
};

/// On the plane. The compiler turns the loop into vectors.
inline void classify(const UprightRow& row, BinnedPixels& pixels) {
  const UprightRow limits{row};
  for (int i{0}; i < pixels.size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    pixels.bins[k] = static_cast<int>(pixels.disparities[i] * column_bins_per_px);
    pixels.between[k] = static_cast<int>(limits.is_below_highest(pixels.columns[i], pixels.disparities[i]));
  }
}

/// Keeps the pixels that are upright on the local ground.
inline void classify(const UprightRow& row, const Relief<Host>& relief, BinnedPixels& pixels) {
  std::size_t size{0};
  for (int i{0}; i < pixels.size; ++i) {
    const int column{pixels.columns[i]};
    const float disparity{pixels.disparities[i]};
    const UprightRow local{row.raised(relief.rows_at(column, disparity))};
    pixels.columns[size] = column;
    pixels.bins[size] = static_cast<int>(disparity * column_bins_per_px);
    pixels.between[size] = static_cast<int>(local.is_below_highest(column, disparity));
    size += local.is_upright(column, disparity) ? 1 : 0;
  }
  pixels.size = static_cast<int>(size);
}

namespace {

constexpr double hanging_m{0.5};  // gap below another object: a bough, a sign, a roof
constexpr double support_m{0.2};  // minimum height of a surface in a column

}  // namespace

void plain::find_upright(const float* row, int width, int begin, int end, const UprightRow& limits,
                         UprightPixels& pixels) {
  pixels.size = 0;
  for (int u{begin}; u < end; ++u) {
    if (!limits.is_upright(u, row[u]) || is_between_surfaces(row, width, u)) continue;
    pixels.columns[pixels.size] = u;
    pixels.disparities[pixels.size] = row[u];
    ++pixels.size;
  }
}

ColumnGeometry::ColumnGeometry(const Rig& level_rig, const UDisparityConfig& heights, int disparities)
    : rig{level_rig}, lowest_m{heights.obstacle_min_height_m}, highest_m{heights.obstacle_height_m} {
  for (int k{0}; k < column_bins_per_px * disparities; ++k) {
    const double rows_per_m{(k + 0.5) / column_bins_per_px / rig.baseline_m};
    bins.push_back({std::max(2, clamped_to_int(std::ceil(support_m * rows_per_m))),
                    std::max(3, clamped_to_int(hanging_m * rows_per_m))});
  }
}

UprightLimits ColumnGeometry::limits(const Ground& ground) const {
  const RoadPlane plane{road_plane(rig, ground)};
  return {plane,
          {.nearest_px = static_cast<float>(size()) / column_bins_per_px,
           .farthest_px = static_cast<float>(rig.focal_px * rig.baseline_m / segments_far_m),
           .road_px = 0,
           .road_per_px = static_cast<float>(plane.per_u),
           .lowest_share = static_cast<float>(1 - lowest_m / ground.height_m),
           .highest_share = static_cast<float>(1 - highest_m / ground.height_m),
           .road_per_row_px = static_cast<float>(plane.per_v)}};
}

ColumnCounter::ColumnCounter(const Rig& level_rig, const UDisparityConfig& heights, int disparities)
    : geometry_{level_rig, heights, disparities},
      tallies_{level_rig.width_px, geometry_.size()},
      counted_{(tallies_.width() + block_columns - 1) / block_columns, tallies_.height()} {
  nodes_.reserve(nodes_reserved(level_rig.width_px, disparities));
}

// Calls work(u) for the tallies of a bin that have pixels.
template <class Work>
void ColumnCounter::for_counted(int bin, const Work& work) const {
  const std::uint16_t* const blocks{counted_.row(bin)};
  for (int i{0}; i < counted_.width(); ++i) {
    for (unsigned left{blocks[i]}; left != 0; left &= left - 1) work(i * block_columns + std::countr_zero(left));
  }
}

// Few tallies have pixels.
void ColumnCounter::clear() {
  for (int k{0}; k < tallies_.height(); ++k) for_counted(k, [&](int u) { tallies_(u, k) = {}; });
  counted_.fill(0);
}

void ColumnCounter::count(View<const float> obstacle, const UprightLimits& limits, const Relief<Host>& relief,
                          int begin, int end) {
  bool is_on_plane{true};
  for (int u{begin}; u < end; u += sector_px) is_on_plane = is_on_plane && is_level(relief, u);
  BinnedPixels pixels;
  for (int v{0}; v < obstacle.height; ++v) {
    const UprightRow row{limits.row(v)};
    for (int u{begin}; u < end; u += UprightPixels::most) {
      find_upright(obstacle.row(v), obstacle.width, u, std::min(u + UprightPixels::most, end), row, pixels);
      is_on_plane ? classify(row, pixels) : classify(row, relief, pixels);
      for (int i{0}; i < pixels.size; ++i)
        add(v, pixels.columns[i], pixels.bins[static_cast<std::size_t>(i)],
            pixels.between[static_cast<std::size_t>(i)]);
    }
  }
}

void ColumnCounter::add(int v, int u, int bin, int between) {
  ColumnTally& tally{tallies_(u, bin)};
  if (tally.top == 0) {
    std::uint16_t& block{counted_(u / block_columns, bin)};
    block = static_cast<std::uint16_t>(block | 1U << u % block_columns);
  }
  tally.add(v, v, between, geometry_.bins[static_cast<std::size_t>(bin)]);
}

void ColumnCounter::collect_nodes() {
  nodes_.clear();
  for (int k{1}; k + 1 < tallies_.height(); ++k) {
    const ColumnBin& bin{geometry_.bins[static_cast<std::size_t>(k)]};
    const ColumnTally* const here{tallies_.row(k)};
    for_counted(k, [&](int u) {
      if (!is_node(here[u], tallies_(u, k - 1).pixels, tallies_(u, k + 1).pixels, bin)) return;
      nodes_.push_back({static_cast<std::uint16_t>(u), static_cast<std::uint16_t>(k), here[u].pixels,
                        static_cast<std::uint16_t>(here[u].top - 1)});
    });
  }
}

}  // namespace stereogrid
