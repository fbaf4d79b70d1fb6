// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "geometry/grid_in_vehicle.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"
#include "terrain/polar_places.hpp"
#include "terrain/relief.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Point of an edge with lower ground behind it.
struct EdgePoint {
  int sector;
  Point2 place;  ///< vehicle frame, m
  float fall_m;  ///< visible part of the fall
};

/// Cell of the window with a low obstacle in memory.
struct LowObstacleCell {
  int ix;
  int iy;
  float height_m;  ///< over the ground around it
  float frames;    ///< HeightMemory::Mean
  bool is_seen;    ///< in this frame
  int group{0};    ///< index of a cell that it touches directly or through others, the same for all of them
};

/// Ground of a frame: elevation, drivable cells, steps, edges (docs/terrain.md). The same loops serve every back end:
/// sectors are independent of each other in all steps but spread_ground().
class Terrain {
 public:
  /// `farthest_m`: end of the grid, `cell_m`: size of its cells.
  Terrain(const Rig& level_rig, const TerrainLimits& limits, Rings rings, int disparities);

  /// Begins a frame. `surface`: plane of the nearest visible ground.
  void begin(const Ground& ground, const Ground& surface);
  /// Input of the frame's walks, valid until the next begin().
  [[nodiscard]] WalkFrame walk_frame() const { return {sampled_, rings_, prior_}; }
  /// Sets the noise of the frame's samples by ring, valid until the next begin().
  void set_noise(const float* sigma_px);
  /// Sets the ground of the frame's walk, after set_noise(). It must stay valid until the next begin().
  void set_walked(const WalkedGround<Host>& walked) { walked_ = walked; }
  /// Relief of that ground, and what visit() needs. `for_ranges`(count, work): calls work(begin, end) on disjoint parts
  /// of [0, count).
  template <class ForRanges>
  void find_relief(const ForRanges& for_ranges) {
    const auto for_sectors = [&](const auto& work) {
      for_ranges(sectors(), [&](int first, int end) {
        for (int sector{first}; sector < end; ++sector) work(sector);
      });
    };
    for_sectors([&](int sector) { relief_.profile(sector, walked_.cells.row(sector)); });
    relief_.count_level();
    for_sectors([&](int sector) { relief_.fill(sector, walked_.cells.row(sector)); });
    count_observed_rings();
  }
  /// Edges of the last find(), from left to right: one a sector at most.
  void add_edges(std::vector<EdgePoint>& edges) const;
  /// After find_relief(): calls work(ix, iy, CellGround) for the cells of rows begin … end − 1 that have ground; the
  /// others have CellGround{}.
  template <class Work>
  void visit(const GridInVehicle& grid, int begin, int end, const Work& work) const {
    const CellPlaces places{grid, {0, 0}, 1};
    const float half_m{static_cast<float>(grid.grid.cell_size_m / 2)};
    const PolarGeometry geometry{polar_geometry(half_m)};
    PolarPlaces borders;  // first cells of groups, and the one behind the last
    PolarPlaces polar;
    const PolarGround<Host> ground{polar_ground()};
    RingPart part;  // neighbours often lie in the same one
    for (int iy{begin}; iy < end; ++iy) {
      const CellSpan row{observed_cells(places, half_m, iy, grid.grid.nx)};
      int group{0};
      for (int ix{row.begin}; ix < row.end; ix += PolarPlaces::size, group = (group + 1) % (PolarPlaces::size - 1)) {
        if (group == 0) find_places(geometry, places, ix, PolarPlaces::size, iy, borders);
        if (has_no_ground(borders, static_cast<std::size_t>(group))) continue;
        find_places(geometry, places, ix, 1, iy, polar);
        const auto cells = static_cast<std::size_t>(std::min(PolarPlaces::size, row.end - ix));
        for (std::size_t i{0}; i < cells; ++i) {
          const int ring{ground.ring_of({polar.ring[i], polar.first[i], polar.last[i]})};
          if (ring == no_ring) continue;
          if (ring != part.ring || polar.first[i] != part.first || polar.last[i] != part.last) {
            part = ground.part_of(ring, polar.first[i], polar.last[i]);
          }
          if (part.has_ground()) work(ix + static_cast<int>(i), iy, ground.ground_at(polar.x[i], part));
        }
      }
    }
  }
  /// Ground of the last find(), for two grids of the same cells. `within`: cells of the one in those of the other.
  [[nodiscard]] GroundFrame<Host> ground_frame(const GridInVehicle& one, const GridInVehicle& other,
                                               const CellsWithin& within) const {
    const auto grid_of = [](const GridInVehicle& grid) {
      return GroundGrid{{grid, {0, 0}, 1}, grid.grid.nx, grid.grid.ny};
    };
    const auto half_m = static_cast<float>(one.grid.cell_size_m / 2);
    return {relief_.model(), polar_ground(), polar_geometry(half_m), {grid_of(one), grid_of(other)}, within};
  }
  /// Ground in the cell around that point, of which the last find() has found none, would be seen: within the range of
  /// edges, and in all of its sectors the last known cell before it is ground.
  [[nodiscard]] bool sees_no_ground_at(Point2 at, float half_m) const;
  [[nodiscard]] const TerrainCamera& camera() const { return camera_; }
  /// Range up to which low obstacles and edges are found.
  [[nodiscard]] float checked_m() const { return checked_rings_ > 0 ? rings_.end_m(checked_rings_ - 1) : 0; }
  /// Noise of the disparities, by place: Rings::places_per_px a pixel.
  [[nodiscard]] std::span<const float> noise_px() const { return noise_px_; }
  [[nodiscard]] Relief<Host> relief() const { return relief_.view(); }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  /// Cells begin … end − 1 of a grid's row.
  struct CellSpan {
    int begin;
    int end;

    /// Drops cells at which start + step · ix < 0.
    void clip(float start, float step);
  };

  [[nodiscard]] CellSpan observed_cells(const CellPlaces& cells, float half_m, int iy, int nx) const;
  [[nodiscard]] PolarGeometry polar_geometry(float half_m) const;
  [[nodiscard]] PolarGround<Host> polar_ground() const {
    return {camera_, rings_, walked_.sigma_px, plane_sigma_m_.data(), walked_.cells};
  }
  [[nodiscard]] bool has_no_ground(const PolarPlaces& borders, std::size_t group) const;
  void count_observed_rings();
  [[nodiscard]] int sectors() const { return static_cast<int>(observed_rings_.size()); }

  Rig rig_;
  TerrainLimits limits_;
  Rings rings_;
  std::vector<float> noise_px_;       // by place
  std::vector<float> plane_sigma_m_;  // by ring: noise of the plane's height
  WalkedGround<Host> walked_;
  TerrainRelief relief_;
  int checked_rings_{0};
  std::vector<int> observed_rings_;  // by sector: up to the last one with a known cell
  Ground ground_;
  FirstGround prior_;
  TerrainCamera camera_;
  SampledGround sampled_;
};

}  // namespace stereogrid
