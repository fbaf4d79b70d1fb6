// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "clamped_to_int.hpp"
#include "elementary_functions.hpp"
#include "ground/model.hpp"
#include "host_device.hpp"
#include "projection/model.hpp"
#include "rays/weights.hpp"
#include "stereogrid/image.hpp"
#include "u_disparity/model.hpp"

namespace stereogrid {

/// Rays are counted in bins of half a pixel of disparity, bin k from k/2 px on.
constexpr int ray_bins_per_px{2};

/// What a row of the column u0 says of a pixel in it.
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

/// Counts of rays in one number, so that they are added and subtracted together: 21 bits for each. What overflows does
/// so again in the difference of two sums, which is right as long as no count of its own needs more bits: see
/// columns_max.
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

/// Sums over all bins before k and all columns before u: (width + 1) rows, by u, of bins + 1. What is looked up of a
/// cell lies in few bins of two columns.
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
  float share;  ///< of one of them

  STEREOGRID_HD ColumnPart(int from, int to) : begin{from}, end{to}, share{1 / static_cast<float>(to - from)} {}
};

/// Rays of some columns in the two rows of sums around a place between bins.
struct RaysAround {
  PackedRays before;
  PackedRays behind;
  float part;  ///< of the way from the one to the other

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

/// What is added to the logarithm of the odds for `count` ≥ 0 rays of a kind (rounding errors below do no harm), but
/// for the factor of known_share. docs/method.md §6.2.
STEREOGRID_HD inline float evidence_of(float count, float unit, float weight) {
  return weight * natural_log(1 + count * (1 / unit));
}

STEREOGRID_HD inline float known_share(float arriving) {
  return arriving / (arriving + half_known_rays);
}

STEREOGRID_HD inline float probability_of(float log_odds) {
  return 1 / (1 + exponential(Min(Max(-log_odds, -log_odds_max), log_odds_max)));
}

/// Of a weighted sum of evidence. What speaks weakly against an obstacle says next to nothing: some obstacles have no
/// match in them, and rays seem to pass through. docs/method.md §6.2.
STEREOGRID_HD inline float log_odds_of(float arriving_rays, float sum) {
  const float log_odds{known_share(arriving_rays) * sum};
  const float square{log_odds * log_odds};
  const float power{square * square * square};
  return log_odds < 0 ? log_odds * (power / (power + power_of_weak_log_odds)) : log_odds;
}

/// P(occupied) of what the rays of a cell say.
STEREOGRID_HD inline float occupancy_of(const CellRays& rays) {
  const RayWeights weights{};
  float sum{0};
  for (int i{0}; i < cell_rays; ++i) sum += evidence_of(rays.count[i], unit_of(i), weights.value[i]);
  return probability_of(log_odds_of(rays.count[arriving], sum));
}

/// The rays of a square of `size_m` around a point of the vehicle frame. False: out of view, nearer than all
/// disparities, or across more than `most_columns`. The square is taken along the vehicle's axes, also for a cell of a
/// turned grid.
template <class Space>
STEREOGRID_HD inline bool find_rays(const RaySums<Space>& sums, int most_columns, const BinGeometry& geometry,
                                    Point2 centre, double size_m, CellRays& rays) {
  const double near_m{centre.x - size_m / 2};
  if (!(near_m > 0)) return false;
  const float near_px{static_cast<float>(geometry.disparity(near_m))};
  const float far_px{static_cast<float>(geometry.disparity(centre.x + size_m / 2))};
  if (near_px > static_cast<float>(bins_of(sums)) / ray_bins_per_px - 1) return false;
  const int width{columns_of(sums)};
  const auto border = [&](double y_m) {  // between two columns; some outside the image
    const double column{geometry.column(centre.x, y_m)};
    const double limited{column < -2 ? -2 : (column > width + 1 ? width + 1 : column)};
    return static_cast<int>(limited + 3) - 2;
  };
  const auto within = [&](int column) { return column < 0 ? 0 : (column < width ? column : width); };
  const int left{border(centre.y + size_m / 2)};
  const int right{border(centre.y - size_m / 2)};
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
  rays.count[ending] = between(ending_ray, around(far_px - 0.5f, wide), around(near_px + 0.5f, wide), wide);
  rays.count[behind] = between(ending_ray, around(far_px - 4, columns), far, columns);
  rays.count[in_front] = between(ending_ray, near, around(near_px + 4, columns), columns);
  rays.count[road_in_front] = between(ending_on_road, near, around(near_px + 1, columns), columns);
  rays.count[arriving] = near.count(arriving_ray) * columns.share;
  rays.count[passing] = far.count(arriving_ray) * columns.share;
  rays.count[passing_farther] = around(far_px - 1, columns).count(arriving_ray) * columns.share;
  return true;
}

/// P(occupied) of that square; ½ where it has no rays.
template <class Space>
STEREOGRID_HD inline float occupancy_at(const RaySums<Space>& sums, int most_columns, const BinGeometry& geometry,
                                        Point2 centre, double size_m) {
  CellRays rays{};
  return find_rays(sums, most_columns, geometry, centre, size_m, rays) ? occupancy_of(rays) : 0.5f;
}

}  // namespace stereogrid
