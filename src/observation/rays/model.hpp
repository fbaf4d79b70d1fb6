// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "clamped_to_int.hpp"
#include "geometry/matches.hpp"
#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
#include "observation/projection/model.hpp"
#include "observation/rays/weights.hpp"
#include "observation/u_disparity/model.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Rays are counted in bins of half a pixel of disparity, bin k from k/2 px on.
constexpr int ray_bins_per_px{2};

/// Fewest ambiguous pixels of a repeating pattern in a column.
constexpr int least_ambiguous{8};

/// Class of a pixel by its row of the column u0.
struct RayRow {
  std::int32_t first;  ///< bin from which on the row lies between the road and the height of obstacles: eq. 9
  std::int32_t end;    ///< and up to which; first ≥ end: nowhere
  float drop;          ///< (row − horizon)·b: at disparity d the pixel is drop/d lower than the camera, in metres
};

/// Heights between which a pixel is part of an obstacle, as distances below the camera.
struct UprightRange {
  float top_drop_m;
  float bottom_drop_m;
};

STEREOGRID_HD inline UprightRange upright_range(double camera_height_m, double lowest_m, double highest_m) {
  return {static_cast<float>(camera_height_m - highest_m), static_cast<float>(camera_height_m - lowest_m)};
}

STEREOGRID_HD inline bool is_upright(float disparity, float drop, const UprightRange& range) {
  return drop >= range.top_drop_m * disparity && drop <= range.bottom_drop_m * disparity;
}

STEREOGRID_HD inline RayRow ray_row(const RowsByHeight& rows, double highest_m, int row, int bins) {
  const double drop{(row - rows.horizon) * rows.baseline_across_m};
  const double top{rows.camera_height_m - highest_m};  // below 0: obstacles higher than the camera
  // on the road where drop = camera_height·d, at the greatest height where drop = top·d
  const double road{drop / rows.camera_height_m};
  const double high{drop / top};
  const double first{drop > 0 ? road : (top < 0 ? high : bins)};
  const double end{drop > 0 && top > 0 ? high : bins};
  const auto bin = [&](double disparity) {
    const double at_most{disparity * ray_bins_per_px < bins ? disparity * ray_bins_per_px : bins};
    return clamped_to_int(at_most);
  };
  return {bin(first), drop == 0 && top >= 0 ? 0 : bin(end), static_cast<float>(drop)};
}

/// Bin of a disparity > 0.
STEREOGRID_HD inline int ray_bin(float disparity) {
  return static_cast<int>(disparity * static_cast<float>(ray_bins_per_px));
}

/// Counts of rays packed into one number, 21 bits each, to be added and subtracted together. Overflows cancel in the
/// difference of two sums while no single count needs more bits: see columns_max.
using PackedRays = std::uint64_t;
constexpr int ray_bits{21};
constexpr PackedRays ending_ray{1};                              ///< obstacle pixels at their disparity
constexpr PackedRays ending_on_road{PackedRays{1} << ray_bits};  ///< road pixels at theirs
/// Pixels with a disparity, from where their ray is seen on: N_V of eq. 11, but between bins.
constexpr PackedRays arriving_ray{PackedRays{1} << 2 * ray_bits};

STEREOGRID_HD inline float count_of(PackedRays rays, PackedRays kind) {
  return static_cast<float>(static_cast<std::uint32_t>(rays / kind) & ((1U << ray_bits) - 1));
}

/// Adds a pixel to the counts of its column: add(bin, rays). A disparity of 0: none.
template <class Add>
STEREOGRID_HD inline void count_ray(float obstacle, float road, const RayRow& row, const UprightRange& range, int bins,
                                    const Add& add) {
  const float disparity{obstacle > 0 ? obstacle : road};
  if (!(disparity > 0)) return;
  const int bin{ray_bin(disparity)};
  const bool ends{obstacle > 0 ? is_upright(disparity, row.drop, range) : true};
  const PackedRays end{ends ? (obstacle > 0 ? ending_ray : ending_on_road) : PackedRays{0}};
  if (bin >= row.first && bin < row.end) {
    add(bin, end + arriving_ray);
  } else {
    if (bin < bins) add(bin, end);
    if (bin < row.first && row.first < row.end) add(row.first, arriving_ray);
  }
  if (bin < row.end && row.first < row.end && row.end < bins) add(row.end, PackedRays{0} - arriving_ray);
}

/// Nothing repeats from this row on.
constexpr int no_foot{-1};

/// Rows of a column, and how many of their pixels are ambiguous.
struct PatternRows {
  int rows;
  int ambiguous;
};

/// Bins from 0 to the foot of a repeating pattern whose lowest ambiguous pixel is in row v; 0: not below the horizon,
/// so no row above is a foot either; no_foot: too few are ambiguous. `count(v, top)`: PatternRows from row v up to the
/// first with a drop below `top`. See opaque_bins.
template <class Row, class Count>
STEREOGRID_HD inline int bins_to_foot(int v, int height, const UprightRange& range, const Row& row,
                                      const Count& count) {
  constexpr int foot_rows{6};  // half of a window with its census, below the lowest ambiguous pixel
  const RayRow& foot{row(v)};
  if (!(foot.drop > 0)) return 0;
  const float disparity{static_cast<float>(foot.first) / ray_bins_per_px};
  const PatternRows seen{count(v, 2 * range.bottom_drop_m * disparity - foot.drop)};
  if (seen.ambiguous < least_ambiguous || 4 * seen.ambiguous < seen.rows) return no_foot;
  return row(v + foot_rows < height ? v + foot_rows : v).first + 1;
}

/// Bins from 0 to the foot of a repeating pattern, which no ray of a column passes; 0: no pattern. An ambiguous pixel
/// shows something nearer than the ground of its row. The foot is the lowest row from which a quarter of the pixels are
/// ambiguous, up to twice the least height of obstacles. `pixel(v)`: obstacle disparity; `row(v)`: RayRow.
template <class Pixel, class Row>
STEREOGRID_HD inline int opaque_bins(int height, const UprightRange& range, const Pixel& pixel, const Row& row) {
  const auto count = [&](int v, float top) {
    PatternRows seen{0, 0};
    for (int above{v}; above >= 0 && row(above).drop >= top; --above) {
      ++seen.rows;
      seen.ambiguous += is_ambiguous(pixel(above)) ? 1 : 0;
    }
    return seen;
  };
  for (int v{height - 1}; v >= 0; --v) {
    if (!is_ambiguous(pixel(v))) continue;
    const int bins{bins_to_foot(v, height, range, row, count)};
    if (bins != no_foot) return bins;
  }
  return 0;
}

/// Removes the rays of a column's sums that arrive before a bin; of those from `first` on, every `step`-th.
STEREOGRID_HD inline void stop_rays(int bins, PackedRays* sums, int first = 0, int step = 1) {
  for (int k{first}; k < bins; k += step) sums[k] %= arriving_ray;
}

/// Sums over all bins before k and all columns before u: (width + 1) rows, by u, of bins + 1. The look-ups of a cell
/// are in few bins of two columns.
template <class Space>
using RaySums = View<const PackedRays, Space>;

template <class Space>
STEREOGRID_HD inline int columns_of(const RaySums<Space>& sums) {
  return sums.height - 1;
}
template <class Space>
STEREOGRID_HD inline int bins_of(const RaySums<Space>& sums) {
  return sums.width - 1;
}

/// As many columns hold no more rays than fit their bits.
STEREOGRID_HD constexpr int columns_max(int height) {
  return ((1 << ray_bits) - 1) / height;
}

/// Columns begin … end − 1.
struct ColumnPart {
  int begin;
  int end;
  float share;  ///< share of one of them

  STEREOGRID_HD ColumnPart(int from, int to) : begin{from}, end{to}, share{1 / static_cast<float>(to - from)} {}
};

/// Rays of some columns in the two rows of sums around a place between bins.
struct RaysAround {
  PackedRays before;
  PackedRays behind;
  float part;  ///< position between both

  [[nodiscard]] STEREOGRID_HD float count(PackedRays kind) const {
    const float least{count_of(before, kind)};
    return least + part * (count_of(behind, kind) - least);
  }
};

/// `disparity` may lie outside the bins.
template <class Space>
STEREOGRID_HD inline RaysAround rays_around(const RaySums<Space>& sums, float disparity, const ColumnPart& columns) {
  const int bins{bins_of(sums)};
  const float last{static_cast<float>(bins)};
  const float bin{disparity * ray_bins_per_px};
  const float place{bin < 0 ? 0.0f : (bin > last ? last : bin)};
  const int k{static_cast<int>(place) < bins - 1 ? static_cast<int>(place) : bins - 1};
  const PackedRays* begin{sums.row(columns.begin) + k};
  const PackedRays* end{sums.row(columns.end) + k};
  return {end[0] - begin[0], end[1] - begin[1], place - static_cast<float>(k)};
}

#include "observation/rays/evidence_formulas.hpp"

/// P(occupied) of what the rays of a cell say.
STEREOGRID_HD inline float occupancy_of(const CellRays& rays) {
  const RayWeights weights{};
  float sum{0};
  for (int i{0}; i < cell_rays; ++i) sum += evidence_of(rays.count[i], unit_of(i), weights.value[i]);
  return probability_of(log_odds_of(rays.count[arriving], sum));
}

/// The cells of a grid as the camera sees them. Single precision is enough for whole columns and half pixels of
/// disparity, and faster on most machines.
struct CellsInView {
  float focal_px;
  float cx_px;
  float focal_baseline_pxm;
  float half_m;       ///< half of a cell's side
  float blur_px;      ///< see blur_of
  CellPlaces places;  ///< m in the vehicle frame

  STEREOGRID_HD CellsInView(const BinGeometry& geometry, const GridInVehicle& cells, float blur)
      : focal_px{static_cast<float>(geometry.focal_px)},
        cx_px{static_cast<float>(geometry.cx_px)},
        focal_baseline_pxm{static_cast<float>(geometry.focal_baseline_pxm)},
        half_m{static_cast<float>(cells.grid.cell_size_m / 2)},
        blur_px{blur},
        places{cells, {0, 0}, 1} {}
};

/// The rays of a cell, taken as a square along the vehicle's axes, also where the grid is turned. False: out of view,
/// nearer than all disparities, or across more than `most_columns`.
template <class Space>
STEREOGRID_HD inline bool find_rays(const RaySums<Space>& sums, int most_columns, const CellsInView& cells, int ix,
                                    int iy, CellRays& rays) {
  const float ahead_m{cells.places.x_of(ix, iy)};
  const float left_m{cells.places.y_of(ix, iy)};
  const float near_m{ahead_m - cells.half_m};
  if (!(near_m > 0)) return false;
  const float near_px{cells.focal_baseline_pxm / near_m};
  const float far_px{cells.focal_baseline_pxm / (ahead_m + cells.half_m)};
  if (near_px > static_cast<float>(bins_of(sums)) / ray_bins_per_px - 1) return false;
  const int width{columns_of(sums)};
  const float columns_per_m{cells.focal_px / ahead_m};
  const auto border = [&](float to_left_m) {  // between two columns; some outside the image
    const float column{cells.cx_px - columns_per_m * to_left_m};
    return static_cast<int>(Min(Max(column, -2.0f), static_cast<float>(width + 1)) + 3) - 2;
  };
  const auto within = [&](int column) { return Min(Max(column, 0), width); };
  const int left{border(left_m + cells.half_m)};
  const int right{border(left_m - cells.half_m)};
  const int end{right > left ? right : left + 1};
  if (within(left) >= within(end)) return false;
  const ColumnPart columns{within(left), within(end)};
  const ColumnPart wide{within(left - columns_around), within(end + columns_around)};
  if (wide.end - wide.begin > most_columns) return false;
  const auto around = [&](float disparity, const ColumnPart& part) { return rays_around(sums, disparity, part); };
  const RaysAround near{around(near_px, columns)};
  const RaysAround far{around(far_px, columns)};
  const auto between = [&](PackedRays kind, const RaysAround& first, const RaysAround& last, const ColumnPart& part) {
    return (last.count(kind) - first.count(kind)) * part.share;
  };
  rays.count[ending] =
      between(ending_ray, around(far_px - cells.blur_px, wide), around(near_px + cells.blur_px, wide), wide);
  rays.count[behind] = between(ending_ray, around(far_px - 4, columns), far, columns);
  rays.count[in_front] = between(ending_ray, near, around(near_px + 4, columns), columns);
  rays.count[road_in_front] = between(ending_on_road, near, around(near_px + 1, columns), columns);
  rays.count[arriving] = near.count(arriving_ray) * columns.share;
  rays.count[passing] = far.count(arriving_ray) * columns.share;
  rays.count[passing_farther] = around(far_px - 1, columns).count(arriving_ray) * columns.share;
  return true;
}

/// P(occupied) of a cell; ½ where it has no rays.
template <class Space>
STEREOGRID_HD inline float occupancy_at(const RaySums<Space>& sums, int most_columns, const CellsInView& cells, int ix,
                                        int iy) {
  CellRays rays{};
  return find_rays(sums, most_columns, cells, ix, iy, rays) ? occupancy_of(rays) : 0.5f;
}

}  // namespace stereogrid
