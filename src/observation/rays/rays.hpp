// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/matches.hpp"
#include "geometry/relief.hpp"
#include "memory_bytes.hpp"
#include "observation/rays/model.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// Working memory and result of `count_rays`. Allocated once.
struct RayWorkspace {
  /// `disparities` 0: nothing, for configurations that do without. `has_relief`: `relief` may be set.
  RayWorkspace(int width, int height, int disparities, bool has_relief = false);

  /// For the road of a frame.
  void place(const Rig& rig, const Ground& ground, const UDisparityConfig& config);

  /// Entry of the pixel (u, v) with this disparity ≥ 0.
  [[nodiscard]] const RayRow& row(int u, int v, float disparity) const {
    const int raised{relief.is_plane() ? 0 : relief.rows_at(u, disparity)};
    return rows[static_cast<std::size_t>(v + margin - shift[static_cast<std::size_t>(u)] + raised)];
  }
  /// Entry of a pixel of the ground.
  [[nodiscard]] const RayRow& ground_row(int u, int v) const {
    const RayRow& on_plane{rows[static_cast<std::size_t>(v + margin - shift[static_cast<std::size_t>(u)])]};
    return row(u, v, static_cast<float>(on_plane.first) / ray_bins_per_px);
  }
  /// Stops the rays of column u, summed over its bins, at the foot of a repeating pattern.
  void stop_at_pattern(const Matches& matches, int u) {
    const auto pixel = [&](int v) { return matches.obstacle(u, v); };
    stop_rays(opaque_bins(height, upright, pixel, [&](int v) { return ground_row(u, v); }), sums.row(u + 1));
  }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(shift, rows, sums); }

  int width;
  int height;
  int bins;
  int margin;                       ///< rows that a pixel may be shifted by, due to roll and relief
  Relief<Host> relief{};            ///< relief of the frame
  std::vector<std::int32_t> shift;  ///< (W) rows by which the road lies lower than in the column u0, due to roll
  std::vector<RayRow> rows;         ///< (height + 2·margin), from row −margin on
  UprightRange upright{};
  float blur_px{widest_blur_px};  ///< blur_of the frame
  Image<PackedRays> sums;         ///< (W + 1, bins + 1), see RaySums
};

/// Half of the depth, in px of disparity, over which noise spreads the pixels of an obstacle: three standard deviations
/// of the disparities on MatchLattice. At most `widest_blur_px`, its value with too few obstacle pixels.
float blur_of(const Matches& matches, int window_px);
/// The same of disparities with this standard deviation, px.
float blur_of(double sigma_px);

/// Counts where the rays of all pixels end, from disparity images.
void count_rays(Cpu& cpu, const Matches& matches, const Rig& rig, const Ground& ground, const UDisparityConfig& config,
                RayWorkspace& space);
void count_rays(Reference& reference, const Matches& matches, const Rig& rig, const Ground& ground,
                const UDisparityConfig& config, RayWorkspace& space);

/// P(occupied) of the cells of a grid anywhere in the vehicle frame, from what the rays of each say together: how many
/// end in it, in front of it, behind it, how many come as far and how many pass. docs/method.md §6.2.
void project_rays(Cpu& cpu, const RayWorkspace& space, const BinGeometry& geometry, const GridInVehicle& grid,
                  View<float> cells);
void project_rays(Reference& reference, const RayWorkspace& space, const BinGeometry& geometry,
                  const GridInVehicle& grid, View<float> cells);

/// Detects groups of cells that no ray reaches, outside of the image or hidden, so that each is ½ (occupancy_at). Cells
/// of undetected groups may still be hidden.
class HiddenCells {
 public:
  HiddenCells(const RaySums<Host>& sums, const BinGeometry& geometry, const GridInVehicle& grid);

  /// The cells from (x_first, y_first) to (x_last, y_last).
  [[nodiscard]] bool are_hidden(int x_first, int y_first, int x_last, int y_last) const;

 private:
  static constexpr int groups_max{256};

  // No ray of the columns arrives before the bin `end`.
  [[nodiscard]] bool is_empty_before(int end, int first_column, int last_column) const;

  BinGeometry geometry_;
  GridInVehicle grid_;
  int width_;
  int bins_;
  int group_columns_;
  std::array<int, groups_max> empty_bins_{};  // by group of columns: number of sums without arriving rays
};

}  // namespace stereogrid
