// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/relief.hpp"
#include "host_device.hpp"
#include "memory_bytes.hpp"
#include "numbers.hpp"
#include "terrain/polar_places.hpp"
#include "terrain/rules.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Place of a bin of the relief between the middles of two rings. Border 0: the footprint, border k + 1: the middle of
/// ring k.
struct ReliefBin {
  int from;
  int to;
  float ahead_m;   ///< distance from the border `from`
  float length_m;  ///< distance between both
  float row_m;     ///< height of a row of the image there
};

/// Formulas of a frame's relief, for CPU and GPU. Elevations in m; NaN: no ground.
struct ReliefModel {
  static constexpr float none_m{std::numeric_limits<float>::quiet_NaN()};
  static constexpr int reach_max{24};  ///< sectors
  // Lengths in heights of the vehicle.
  static constexpr float half_width{1.4f};  ///< least half width of wide ground
  static constexpr float slope_base{1.4f};  ///< length over which a slope is measured
  static constexpr float continued{1.7f};   ///< length over which the slope of the last ground is extended
  static constexpr float noise_min_m{0.06f};
  static constexpr float noise_sigmas{2};

  /// Elevation up to which ground of a ring is level.
  [[nodiscard]] STEREOGRID_HD float level_m(int ring) const {
    const float sigma_m{camera.elevation_sigma(camera.height_m, rings.middle_m(ring), sigma_px[ring])};
    return Max(Min(noise_min_m, limits.step_m / 2), noise_sigmas * sigma_m);
  }
  /// Elevation of firm ground. Pixels of a rising surface are noisier than those of a level one: its upper bound
  /// counts.
  [[nodiscard]] STEREOGRID_HD float elevation(const PolarCell& cell, int ring) const {
    if (!cell.is_ground() || !cell.is_firm) return none_m;
    const float x{rings.middle_m(ring)};
    const float sigma_m{camera.height_sigma(camera.height_m - cell.elevation_m, cell.slope, x, sigma_px[ring])};
    const float level_sigma_m{camera.elevation_sigma(camera.height_m, x, sigma_px[ring])};
    return cell.elevation_m + noise_sigmas * Max(sigma_m - level_sigma_m, 0.0f);
  }
  /// Width of a sector in a ring.
  [[nodiscard]] STEREOGRID_HD float sector_m(int ring) const {
    return sector_px * rings.middle_m(ring) / camera.focal_px;
  }
  /// Sectors on both sides that wide ground needs.
  [[nodiscard]] STEREOGRID_HD int reach(int ring) const {
    return Min(Max(static_cast<int>(half_width * limits.height_m / sector_m(ring)), 2), reach_max);
  }
  /// The vehicle reaches ground at `z` from the median, `apart` sectors beside it.
  [[nodiscard]] STEREOGRID_HD bool is_reached(float z, float median, int ring, int apart) const {
    return std::abs(z - median) < noise_m[ring] + limits.slope * sector_m(ring) * static_cast<float>(apart);
  }
  /// More than half of the sectors.
  [[nodiscard]] STEREOGRID_HD static bool is_most(int sectors, int all) { return 2 * sectors > all; }
  /// The matcher's smear raises the ring before an obstacle. `cells`: of one sector, by ring.
  [[nodiscard]] STEREOGRID_HD bool is_before_obstacle(int ring, const PolarCell* cells) const {
    return ring + 1 < rings.count() && cells[ring + 1].kind == TerrainClass::obstacle;
  }
  /// Keeps wide ground that continues the ground before it. `ground`: of one sector, by ring.
  STEREOGRID_HD void connect(float* ground) const;
  /// Elevations at the borders. They grow from 0 at the noise to their full value at twice the noise. Extended ground
  /// has twice the noise.
  STEREOGRID_HD void set_borders(const float* ground, float* border) const;
  /// `before`: border from which on it is searched.
  [[nodiscard]] STEREOGRID_HD ReliefBin bin_at(int bin, int before) const {
    const float x{camera.range((static_cast<float>(bin) + 0.5f) / relief_bins_per_px)};
    int next{before};
    while (x > border_x(next) && next < rings.count()) ++next;
    const bool is_beyond{x > border_x(next)};
    const int from{is_beyond ? next : next - 1};
    return {from, next, is_beyond ? 0 : x - border_x(from), is_beyond ? 1 : border_x(next) - border_x(from),
            x * camera.tangent_per_v};
  }
  /// Rows of the image by which the ground is raised in a bin.
  [[nodiscard]] STEREOGRID_HD std::int16_t rows(const ReliefBin& at, const float* border) const {
    const auto most = static_cast<float>(height_px);
    const float z{border[at.from] + (border[at.to] - border[at.from]) * at.ahead_m / at.length_m};
    const float raised{Min(Max(z / at.row_m, -most), most)};
    const int whole{static_cast<int>(raised)};
    const float part{raised - static_cast<float>(whole)};
    return static_cast<std::int16_t>(whole + (part >= 0.5f ? 1 : 0) - (part <= -0.5f ? 1 : 0));
  }
  [[nodiscard]] STEREOGRID_HD float border_x(int border) const { return border == 0 ? 0 : rings.middle_m(border - 1); }

  TerrainCamera camera{Rig{}, Ground{}};
  TerrainLimits limits{};
  FirstGround prior{};
  RingTable rings{};
  const float* sigma_px{nullptr};  ///< noise of disparities, by ring
  const float* noise_m{nullptr};   ///< level_m() by ring
  int height_px{0};
};

/// Ground of a sector that continues from the rings before a ring, along the slope of the last slope_base. Rings in
/// ascending order; `ground_m`: NaN: none.
class GroundLine {
 public:
  STEREOGRID_HD GroundLine(const float* ground_m, const ReliefModel& model) : z_{ground_m}, model_{model} {}

  [[nodiscard]] STEREOGRID_HD float elevation_at(int ring) {
    const RingTable& rings{model_.rings};
    const float base_m{ReliefModel::slope_base * model_.limits.height_m};
    for (; seen_ < ring; ++seen_) {
      if (!std::isnan(z_[seen_])) last_ = seen_;
    }
    if (last_ < 0) return model_.prior.elevation(rings.middle_m(ring));
    const float x{rings.middle_m(last_)};
    for (; searched_ <= last_ && x - rings.middle_m(searched_) >= base_m; ++searched_) {
      if (!std::isnan(z_[searched_])) first_ = searched_;
    }
    const float slope{first_ < 0 ? z_[last_] / Max(x, base_m)  // from the footprint
                                 : (z_[last_] - z_[first_]) / (x - rings.middle_m(first_))};
    return z_[last_] + slope * Min(rings.middle_m(ring) - x, ReliefModel::continued * model_.limits.height_m);
  }

 private:
  const float* z_;
  const ReliefModel& model_;
  int last_{-1};     ///< last ring with ground
  int first_{-1};    ///< last ring with ground by slope_base before it
  int seen_{0};      ///< rings that `last_` is of
  int searched_{0};  ///< rings that `first_` is of
};

STEREOGRID_HD inline void ReliefModel::connect(float* ground) const {
  GroundLine line{ground, *this};
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float expected{line.elevation_at(ring)};
    if (!(std::abs(ground[ring] - expected) < Max(limits.step_m, 2 * noise_m[ring]))) ground[ring] = none_m;
  }
}

STEREOGRID_HD inline void ReliefModel::set_borders(const float* ground, float* border) const {
  border[0] = 0;
  GroundLine line{ground, *this};
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float known{ground[ring]};
    const float z{std::isnan(known) ? line.elevation_at(ring) : known};
    const float noise{(std::isnan(known) ? 2 : 1) * noise_m[ring]};
    border[ring + 1] = Min(Max(2 * (z - Min(Max(z, -noise), noise)), Min(z, 0.0f)), Max(z, 0.0f));
  }
}

/// Input of a frame's relief and cells, for CPU and GPU.
template <class Space>
struct GroundFrame {
  ReliefModel relief;
  PolarGround<Space> ground;
  PolarGeometry geometry;           ///< cells of both grids
  std::array<GroundGrid, 2> grids;  ///< the vehicle's grid and the window
  CellsWithin within;               ///< the vehicle's cells in those of the window
};

/// The ground of all sectors as a Relief. Ground must be wide and continue, which excludes the feet of obstacles.
/// Elevations within the noise are 0: level ground is the plane.
class TerrainRelief {
 public:
  TerrainRelief(int sectors, int rings, int disparities, int height_px);

  /// Sets the data of all sectors, before the functions below. `sigma_px`: noise of disparities by ring.
  void begin(const TerrainCamera& camera, const TerrainLimits& limits, const RingTable& rings, const float* sigma_px,
             const FirstGround& prior);
  /// Elevations of one sector's rings.
  void profile(int sector, const PolarCell* cells);
  /// Prepares fill(), once all sectors have a profile.
  void count_level();
  void fill(int sector, const PolarCell* cells);

  [[nodiscard]] const ReliefModel& model() const { return model_; }
  [[nodiscard]] Relief<Host> view() const { return {rows_.view()}; }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(elevation_m_, ground_before_, level_before_, ground_m_, noise_m_, border_m_, bins_, rows_);
  }

 private:
  [[nodiscard]] float wide_ground(int sector, int ring) const;

  ReliefModel model_;
  Image<float> elevation_m_;           // (ring, sector)
  Image<std::int16_t> ground_before_;  // (sector, ring): sectors before it with firm ground
  Image<std::int16_t> level_before_;   // (sector, ring): sectors before it with elevations within the noise
  Image<float> ground_m_;              // (ring, sector): wide ground
  std::vector<float> noise_m_;         // by ring
  Image<float> border_m_;              // (border, sector): elevation
  std::vector<ReliefBin> bins_;
  Image<std::int16_t> rows_;  // (bin, sector)
};

}  // namespace stereogrid
