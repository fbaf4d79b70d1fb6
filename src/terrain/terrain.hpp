// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "held_bytes.hpp"
#include "observation/projection/model.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Elevation and class of a grid's cells.
struct TerrainCells {
  View<float> elevation_m;        ///< NaN: unseen
  View<float> elevation_sigma_m;  ///< NaN: unseen
  View<TerrainClass> kind;
};

/// Ground of a frame: elevation, drivable cells, steps, edges (docs/terrain.md). The same loops serve every back end:
/// sectors are independent of each other within a sweep.
class Terrain {
 public:
  /// `farthest_m`: end of the grid, `cell_m`: its cells.
  Terrain(const Rig& level_rig, const TerrainLimits& limits, float cell_m, float farthest_m, int disparities,
          int window_px);

  /// `for_ranges`(count, work): calls work(begin, end) on disjoint parts of [0, count).
  template <class ForRanges>
  void find(View<const float> obstacle, View<const float> road, const Ground& ground, const ForRanges& for_ranges) {
    begin(ground);
    const int sectors{samples_.sectors()};
    const auto for_sectors = [&](const auto& work) {
      for_ranges(sectors, [&](int first, int end) {
        for (int sector{first}; sector < end; ++sector) work(sector);
      });
    };
    for_sectors([&](int sector) { samples_.read(sector, obstacle, road); });
    for_sectors([&](int sector) { samples_.place(sector, rings_); });
    begin_walks();
    for (int sweep{0}; sweep < sweeps; ++sweep) {
      for_sectors([&](int sector) { walk(sweep, sector); });
    }
    for_sectors([&](int sector) { settle(sector); });
  }
  /// Without a reliable frame: nothing is seen.
  void clear() { is_seen_ = false; }

  /// Rows begin … end − 1 of a grid.
  void write(const GridInVehicle& grid, int begin, int end, const TerrainCells& cells) const;

  [[nodiscard]] std::size_t held_bytes() const;

 private:
  static constexpr int sweeps{3};

  struct CellGround {
    float elevation_m{std::numeric_limits<float>::quiet_NaN()};
    float sigma_m{std::numeric_limits<float>::quiet_NaN()};
    TerrainClass kind{TerrainClass::unknown};
  };

  [[nodiscard]] int sector_at(float x, float y) const;
  [[nodiscard]] CellGround ground_at(float x, float y, float half_m) const;
  void begin(const Ground& ground);
  void begin_walks();
  void walk(int sweep, int sector);
  void settle(int sector);
  [[nodiscard]] const Image<PolarCell>& result() const { return cells_[(sweeps - 1) % 2]; }

  Rig rig_;
  TerrainLimits limits_;
  float window_rows_;
  Rings rings_;
  TerrainSamples samples_;
  std::vector<float> sigma_px_;       // by ring
  std::vector<float> plane_sigma_m_;  // by ring: of the plane
  Image<PolarCell> cells_[2];         // (ring, sector), of the sweeps in turn
  Image<SectorWalk> walks_;           // (sector, 0)
  int judged_rings_{0};
  bool is_seen_{false};
  Ground ground_;
  TerrainCamera camera_;
};

}  // namespace stereogrid
