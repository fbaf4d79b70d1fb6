// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
    const int first_row{begin(terrain, window)};
    for_ranges(samples_.height() - first_row, [&](int begin, int end) {
      for (int v{first_row + begin}; v < first_row + end; ++v) read_row(obstacle, road, v);
    });
    sort_samples(first_row);
    for_rows(for_ranges, [&](int iy) { set_levels(terrain, iy); });
    for (int pass{0}; pass < plane_passes; ++pass) {
      for_rows(for_ranges, [&](int iy) { sum_along(iy, pass); });
      fit_planes();
    }
    for_rows(for_ranges, [&](int iy) { compare(iy); });
    check();
  }

  /// The last find() shows something in the cell that is higher than the ground around it.
  [[nodiscard]] bool is_high_at(float x_m, float y_m) const {
    const int ix{static_cast<int>(origin_east_ + cos_ * x_m + sin_ * y_m)};
    const int iy{static_cast<int>(origin_north_ + cos_ * y_m - sin_ * x_m)};
    return is_within(ix, iy) && seen_(ix, iy).is_high;
  }
  /// Moves the memory with the window.
  void move(Scroll scroll) { memory_.move(scroll); }
  /// Adds the last find() to the memory.
  void remember();
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
    return memory_bytes_of(samples_, read_, sorted_, ranges_, level_m_, noise_m_, moments_, sums_, planes_, seen_,
                           memory_);
  }

 private:
  static constexpr int plane_passes{4};

  struct Range {
    int begin;
    int end;
  };
  /// A pixel over the frame's plane.
  struct Sample {
    std::int32_t cell;
    std::int16_t z;     ///< 1/4096 m
    std::uint8_t east;  ///< place in the cell, 1/256
    std::uint8_t north;
  };
  /// Samples of a row of the image, and the box of the window that they are in.
  struct RowRead {
    int count;
    Range columns;
    Range rows;
  };
  /// Sums of a weighted fit z = g + a·x + b·y; x and y in cells of the window, z in 1/4096 m.
  struct Moments {
    std::int64_t n, x, y, xx, xy, yy, z, xz, yz;

    void add(const Moments& of, std::int64_t times);
  };
  /// Ground around a cell.
  struct Plane {
    float z;     ///< at the middle of the cell, m; NaN: none
    float east;  ///< rise, m per cell
    float north;
  };
  struct Seen {
    int count;  ///< samples, up to HeightMemory::samples_enough; 0: none, or wrong ones
    int high;   ///< samples over the ground
    bool is_high;
    bool is_tall;         ///< rays show it
    bool is_beside_tall;  ///< it or a neighbour is
    float height;         ///< upper decile over the plane, in units of what the matcher leaves of a step
  };
  template <class ForRanges, class Work>
  void for_rows(const ForRanges& for_ranges, const Work& work) {
    for_ranges(rows_.end - rows_.begin, [&](int begin, int end) {
      for (int iy{rows_.begin + begin}; iy < rows_.begin + end; ++iy) work(iy);
    });
  }
  [[nodiscard]] bool is_within(int ix, int iy) const {
    return ix >= columns_.begin && ix < columns_.end && iy >= rows_.begin && iy < rows_.end;
  }
  [[nodiscard]] std::span<Sample> samples_of(int ix, int iy);
  int begin(const Terrain& terrain, const GridInVehicle& window);
  void read_row(View<const float> obstacle, View<const float> road, int v);
  void sort_samples(int first_row);
  void set_levels(const Terrain& terrain, int iy);
  void sum_along(int iy, int pass);
  void fit_planes();
  void compare(int iy);
  [[nodiscard]] float fall_before(int ix, int iy, const Plane& plane) const;
  /// Height that the matcher leaves of a step, where a row of the image is row_m high.
  [[nodiscard]] float matched_step_m(float row_m) const;
  /// Samples of the face of such a step that is a cell wide.
  [[nodiscard]] float face_samples(float row_m) const;
  [[nodiscard]] bool is_small(int ix, int iy) const;
  void leave_tall_obstacles(int ix, int iy);
  void check();

  TerrainLimits limits_;
  float cell_m_;
  float cx_px_;
  int reach_;        ///< cells on both sides of a plane's cell
  float lost_rows_;  ///< rows of a face that the matcher's window takes
  TerrainCamera camera_;
  CellPlaces places_;
  float least_px_{0};   ///< disparity at the end
  int column_step_{1};  ///< columns between samples
  float origin_east_{0};
  float origin_north_{0};
  float cos_{1};
  float sin_{0};
  Range columns_{0, 0};  // box of the window that has samples
  Range rows_{0, 0};
  Image<Sample> samples_;      // by row of the image
  std::vector<RowRead> read_;  // by row of the image
  std::vector<Sample> sorted_;
  Image<Range> ranges_;   // by cell: its samples in sorted_
  Image<float> level_m_;  // median; NaN: none
  Image<float> noise_m_;
  Image<Moments> moments_;     // sums along a row
  std::vector<Moments> sums_;  // moments of the cells of a row
  Image<Plane> planes_;
  Image<Seen> seen_;
  HeightMemory memory_;
};

}  // namespace stereogrid
