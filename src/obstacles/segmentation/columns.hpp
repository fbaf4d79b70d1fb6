// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/relief.hpp"
#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// About half a matching window. Pixels within this distance of a depth edge …
constexpr int edge_reach_px{5};
/// … that differ from both of its surfaces by more than this belong to neither.
constexpr float edge_step_px{1.2f};
/// Bins of the u-disparity plane in which obstacles are segmented.
constexpr int column_bins_per_px{2};
/// Maximum depth of segmented obstacles.
constexpr double segments_far_m{40};

/// Limits of the disparities of obstacles in an image row.
struct UprightRow {
  float nearest_px;
  float farthest_px;
  float road_px;             ///< disparity of the road in column 0
  float road_per_px;         ///< change of the road's disparity per column
  float lowest_share;        ///< maximum ratio of the road's disparity to a pixel's, for the minimum obstacle height
  float highest_share;       ///< its minimum, for the maximum obstacle height
  float road_per_row_px{0};  ///< change of the road's disparity per row

  [[nodiscard]] STEREOGRID_HD float road(int u) const { return road_px + road_per_px * static_cast<float>(u); }
  [[nodiscard]] STEREOGRID_HD bool is_upright(int u, float d) const {
    return d > farthest_px && d < nearest_px && road(u) <= lowest_share * d;
  }
  [[nodiscard]] STEREOGRID_HD bool is_below_highest(int u, float d) const { return road(u) > highest_share * d; }
  /// Limits over the local ground; `rows`: see Relief::rows_at.
  [[nodiscard]] STEREOGRID_HD UprightRow raised(int rows) const {
    UprightRow local{*this};
    local.road_px += road_per_row_px * static_cast<float>(rows);
    return local;
  }
};

/// True: within edge_reach_px are both a larger and a smaller disparity, by more than edge_step_px.
STEREOGRID_HD inline bool is_between_surfaces(const float* row, int width, int u) {
  const int begin{u > edge_reach_px ? u - edge_reach_px : 0};
  const int end{u + edge_reach_px < width ? u + edge_reach_px + 1 : width};
  bool nearer{false};
  bool farther{false};
  for (int i{begin}; i < end; ++i) {
    nearer |= row[i] > row[u] + edge_step_px;
    farther |= row[i] > 0 && row[i] < row[u] - edge_step_px;
  }
  return nearer && farther;
}

struct UprightPixels {
  static constexpr int most{256};

  int size{0};
  std::int32_t columns[most];  // NOLINT(modernize-avoid-c-arrays): not set to 0 for each part
  float disparities[most];     // NOLINT(modernize-avoid-c-arrays)
};

/// Obstacle pixels in the columns `begin` … `end` − 1 (UprightPixels::most at most) of a row of `width` disparities
/// (px, 0 = none). Excludes pixels between two surfaces.
void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels);

/// The same in plain loops: the definition.
namespace plain {
void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels);
}

/// Obstacle pixels of one image column whose disparities lie in one bin: a node of the segments.
struct alignas(8) ColumnNode {
  std::uint16_t u;
  std::uint16_t bin;
  std::uint16_t pixels;  ///< number of pixels between the heights of obstacles
  std::uint16_t top;     ///< first row of the lowest run of rows of any height

  friend bool operator==(const ColumnNode&, const ColumnNode&) = default;
};

/// Limits of a bin's nodes.
struct ColumnBin {
  int pixels_min;  ///< minimum pixels of a node and its neighbours
  int gap_rows;    ///< maximum gap within an object, in rows
};

/// Pixels of a bin in a column, counted from the first row on.
struct ColumnTally {
  std::uint16_t pixels{0};  ///< number of pixels between the heights of obstacles
  std::uint16_t top{0};     ///< first row + 1 of the lowest run of rows of any height; 0: none
  std::uint16_t bottom{0};  ///< last row so far

  /// Adds the rows `first` … `last`, of which `between` are between the heights of obstacles.
  STEREOGRID_HD void add(int first, int last, int between, const ColumnBin& bin) {
    pixels = static_cast<std::uint16_t>(pixels + between);
    if (top == 0 || first - bottom > bin.gap_rows) top = static_cast<std::uint16_t>(first + 1);
    bottom = static_cast<std::uint16_t>(last);
  }
};

/// True: a node. `before`, `after`: pixels of the bins beside it.
STEREOGRID_HD inline bool is_node(const ColumnTally& tally, int before, int after, const ColumnBin& bin) {
  return tally.pixels > 0 && tally.pixels + before + after >= bin.pixels_min;
}

/// Limits of the rows of a frame.
struct UprightLimits {
  RoadPlane plane;
  UprightRow horizontal;  ///< without `road_px`

  [[nodiscard]] UprightRow row(int v) const {
    UprightRow limits{horizontal};
    limits.road_px = static_cast<float>(plane.disparity(0, v));
    return limits;
  }
};

/// Geometry of the nodes of a camera.
struct ColumnGeometry {
  ColumnGeometry(const Rig& level_rig, const UDisparityConfig& heights, int disparities);

  [[nodiscard]] UprightLimits limits(const Ground& ground) const;
  [[nodiscard]] int size() const { return static_cast<int>(bins.size()); }

  Rig rig;
  double lowest_m;
  double highest_m;
  std::vector<ColumnBin> bins;
};

/// Finds the nodes in an image of disparities, on the CPU.
class ColumnCounter {
 public:
  ColumnCounter(const Rig& level_rig, const UDisparityConfig& heights, int disparities);

  /// Nodes by ascending bin and column, until the next call. `obstacle`: (H, W) px, 0 = none.
  /// `for_ranges(count, work)` calls work(begin, end) on disjoint parts of [0, count), possibly on several threads.
  template <class ForRanges>
  std::span<const ColumnNode> find(View<const float> obstacle, const Ground& ground, const Relief<Host>& relief,
                                   const ForRanges& for_ranges) {
    clear();
    const UprightLimits limits{geometry_.limits(ground)};
    for_ranges((obstacle.width + block_columns - 1) / block_columns, [&](int first, int last) {
      count(obstacle, limits, relief, first * block_columns, std::min(last * block_columns, obstacle.width));
    });
    collect_nodes();
    return nodes_;
  }

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(geometry_.bins, tallies_, counted_, nodes_); }

 private:
  static constexpr int block_columns{16};  ///< whole vectors, and the bits of an element of counted_

  void clear();
  template <class Work>
  void for_counted(int bin, const Work& work) const;
  void count(View<const float> obstacle, const UprightLimits& limits, const Relief<Host>& relief, int begin, int end);
  void add(int v, int u, int bin, int between);
  void collect_nodes();

  ColumnGeometry geometry_;
  Image<ColumnTally> tallies_;    ///< (bins, W)
  Image<std::uint16_t> counted_;  ///< (bins, W / block_columns): a bit for each tally with pixels
  std::vector<ColumnNode> nodes_;
};

/// Reserved capacity for nodes: far more than a street has.
constexpr std::size_t nodes_reserved(int width_px, int disparities) {
  return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(column_bins_per_px * disparities) / 8;
}

}  // namespace stereogrid
