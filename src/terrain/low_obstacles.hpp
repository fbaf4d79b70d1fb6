// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/grid_in_vehicle.hpp"
#include "geometry/window.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"
#include "terrain/height_memory.hpp"
#include "terrain/low_obstacles_model.hpp"
#include "terrain/terrain.hpp"

namespace stereogrid {

/// Stones, steps and rises that are hardly higher than a step, in the cells of the filter's window: heights of all
/// pixels over the ground around their cell, and their mean over the frames (docs/terrain.md, "Low obstacles"). Sums of
/// samples are of integers, so that results do not depend on the order.
class LowObstacles {
 public:
  LowObstacles(const Rig& level_rig, const TerrainLimits& limits, double cell_m, int window_cells, int window_px);

  /// Heights of the frame that `terrain` is of.
  template <class ForRanges>
  void find(View<const float> obstacle, View<const float> road, const Terrain& terrain, const GridInVehicle& window,
            const ForRanges& for_ranges) {
    model_.begin(terrain.camera(), window, terrain.checked_m(), samples_.height());
    const int first_row{model_.first_row};
    for_ranges(samples_.height() - first_row, [&](int begin, int end) {
      for (int v{first_row + begin}; v < first_row + end; ++v)
        read_[static_cast<std::size_t>(v)] = read_row(obstacle, road, v);
    });
    sort_samples();
    for_rows(for_ranges, [&](int iy) { set_levels(terrain, iy); });
    for (int pass{0}; pass < LowModel::plane_passes; ++pass) {
      for_rows(for_ranges, [&](int iy) { sum_along(iy, pass); });
      fit_planes();
    }
    for_rows(for_ranges, [&](int iy) { compare(iy); });
    check();
  }

  /// Calls work(ix, iy) for the cells in which the last find() shows something higher than the ground around them.
  template <class Work>
  void for_high(const Work& work) const {
    for (int iy{rows_.begin}; iy < rows_.end; ++iy) {
      for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
        if (seen_(ix, iy).is_high) work(ix, iy);
      }
    }
  }
  /// A frame without images.
  void find_nothing() { columns_ = rows_ = {0, 0}; }
  /// Moves the memory with the window.
  void move(Scroll scroll) { memory_.move(scroll); }
  /// Adds the last find() of a camera, this one or another, to the memory.
  void remember(const LowObstacles& of);
  /// Calls work(ix, iy) for the cells with an obstacle in memory.
  template <class Work>
  void for_obstacles(const Work& work) const {
    memory_.for_obstacles(work);
  }
  void reset() { memory_.reset(); }
  template <class State>
  void exchange(State& state) {
    memory_.exchange(state);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(samples_, read_, sorted_, ranges_, level_m_, top_m_, noise_m_, weights_, moments_, sums_,
                           planes_, seen_, memory_);
  }

 private:
  using Weight = LowWeight<double>;
  using RowMoments = LowRowMoments<double>;
  using Moments = LowMoments<double>;

  struct Range {
    int begin;
    int end;
  };
  /// A pixel over the frame's plane.
  struct Sample {
    std::int32_t cell;
    std::int16_t z;  ///< 1/4096 m
  };
  /// Samples of a row of the image, and the box of the window that they are in.
  struct RowRead {
    int count;
    Range columns;
    Range rows;
  };
  template <class ForRanges, class Work>
  void for_rows(const ForRanges& for_ranges, const Work& work) {
    for_ranges(rows_.end - rows_.begin, [&](int begin, int end) {
      for (int iy{rows_.begin + begin}; iy < rows_.begin + end; ++iy) work(iy);
    });
  }
  [[nodiscard]] std::span<std::int16_t> heights_of(int ix, int iy);
  [[nodiscard]] RowRead read_row(View<const float> obstacle, View<const float> road, int v);
  void sort_samples();
  void set_levels(const Terrain& terrain, int iy);
  void sum_along(int iy, int pass);
  void fit_planes();
  void compare(int iy);
  /// Depth of the lowest level below its plane in the window of a cell's plane, m.
  [[nodiscard]] float depth_around(int ix, int iy) const;
  [[nodiscard]] bool is_small(int ix, int iy) const;
  void leave_tall_obstacles(int ix, int iy);
  void check();

  LowModel model_;
  Range columns_{0, 0};  // box of the window that has samples
  Range rows_{0, 0};
  Image<Sample> samples_;             // by row of the image
  std::vector<RowRead> read_;         // by row of the image
  std::vector<std::int16_t> sorted_;  // heights by cell
  Image<Range> ranges_;               // by cell: its samples in sorted_
  Image<float> level_m_;              // median; NaN: none
  Image<float> top_m_;                // upper decile
  Image<float> noise_m_;
  Image<Weight> weights_;
  Image<RowMoments> moments_;
  std::vector<Moments> sums_;  // moments of a row's cells
  Image<LowPlane> planes_;
  Image<LowSeen> seen_;
  HeightMemory memory_;
};

}  // namespace stereogrid
