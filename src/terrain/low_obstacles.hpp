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

namespace stereogrid {

/// Finds a frame's low obstacles, on the CPU: heights of all pixels over the ground around their cell. Sums of samples
/// are of integers, so that results do not depend on the order.
class LowObstacleFinder {
 public:
  LowObstacleFinder(const Rig& level_rig, int window_cells);

  /// Cells with samples that count, in any order, until the next call. `obstacle`, `road`: (H, W) px, 0 = none.
  /// `noise_px`: see Terrain::noise_px(). `for_ranges`(count, work): calls work(begin, end) on disjoint parts of
  /// [0, count).
  template <class ForRanges>
  std::span<const LowCell> find(View<const float> obstacle, View<const float> road, const LowModel& model,
                                std::span<const float> noise_px, const ForRanges& for_ranges) {
    model_ = &model;
    const int first_row{model.first_row};
    for_ranges(samples_.height() - first_row, [&](int begin, int end) {
      for (int v{first_row + begin}; v < first_row + end; ++v)
        read_[static_cast<std::size_t>(v)] = read_row(obstacle, road, v);
    });
    sort_samples();
    for_rows(for_ranges, [&](int iy) { set_levels(noise_px, iy); });
    for (int pass{0}; pass < LowModel::plane_passes; ++pass) {
      for_rows(for_ranges, [&](int iy) { sum_along(iy, pass); });
      fit_planes();
    }
    for_rows(for_ranges, [&](int iy) { compare(iy); });
    check();
    return found_;
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(samples_, read_, sorted_, ranges_, level_m_, top_m_, noise_m_, weights_, moments_, sums_,
                           planes_, seen_, found_);
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
  template <class Work>
  void for_cells(const Work& work) {
    for (int iy{rows_.begin}; iy < rows_.end; ++iy) {
      for (int ix{columns_.begin}; ix < columns_.end; ++ix) work(ix, iy);
    }
  }
  template <class ForRanges, class Work>
  void for_rows(const ForRanges& for_ranges, const Work& work) {
    for_ranges(rows_.end - rows_.begin, [&](int begin, int end) {
      for (int iy{rows_.begin + begin}; iy < rows_.begin + end; ++iy) work(iy);
    });
  }
  [[nodiscard]] std::span<std::int16_t> heights_of(int ix, int iy);
  [[nodiscard]] RowRead read_row(View<const float> obstacle, View<const float> road, int v);
  void sort_samples();
  void set_levels(std::span<const float> noise_px, int iy);
  void sum_along(int iy, int pass);
  void fit_planes();
  void compare(int iy);
  /// Depth of the lowest level below its plane in the window of a cell's plane, m.
  [[nodiscard]] float depth_around(int ix, int iy) const;
  [[nodiscard]] bool is_small(int ix, int iy) const;
  void mark_beside_tall(int ix, int iy);
  void check();

  const LowModel* model_{nullptr};  // during find()
  Range columns_{0, 0};             // box of the window that has samples
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
  std::vector<LowCell> found_;
};

/// Stones, steps and rises that are hardly higher than a step, in the cells of the filter's window, in a frame and over
/// the frames (docs/terrain.md, "Low obstacles").
class LowObstacles {
 public:
  explicit LowObstacles(const LowModel& model) : model_{model}, memory_{model.cells} {}

  /// Geometry of a frame, for LowObstacleFinder.
  const LowModel& begin(const TerrainCamera& camera, const GridInVehicle& window, float checked_m) {
    model_.begin(camera, window, checked_m);
    return model_;
  }
  /// Sets the cells of the frame; empty: without images. They must stay valid until the next frame.
  void see(std::span<const LowCell> cells) { seen_ = cells; }
  /// Calls work(ix, iy) for the cells in which the frame shows something higher than the ground around them.
  template <class Work>
  void for_high(const Work& work) const {
    for (const LowCell& cell : seen_) {
      if (cell.is_high) work(static_cast<int>(cell.ix), static_cast<int>(cell.iy));
    }
  }
  /// Calls work(ix, iy) for the cells that the frame shows.
  template <class Work>
  void for_seen(const Work& work) const {
    for (const LowCell& cell : seen_) work(static_cast<int>(cell.ix), static_cast<int>(cell.iy));
  }
  /// Moves the memory with the window.
  void move(Scroll scroll) { memory_.move(scroll); }
  /// Adds the frame of a camera, this one or another, to the memory.
  void remember(const LowObstacles& of);
  /// Likewise its bars. `occupancy`: the filter's, in the window.
  void remember_bars(const LowObstacles& of, View<const float> occupancy);
  [[nodiscard]] const HeightMemory& memory() const { return memory_; }
  /// Height over the ground of a mean height in memory, m.
  [[nodiscard]] float height_m(float mean) const { return model_.height_of(mean); }
  void reset() { memory_.reset(); }
  template <class State>
  void exchange(State& state) {
    memory_.exchange(state);
  }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(memory_); }

 private:
  LowModel model_;
  std::span<const LowCell> seen_;
  HeightMemory memory_;
};

}  // namespace stereogrid
