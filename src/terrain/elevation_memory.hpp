// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "geometry/window.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Elevations of the cells of the filter's window over the frames, above the ground plane of the last one
/// (docs/terrain.md, "Elevation over time"). Unseen cells keep theirs, less surely with each frame.
class ElevationMemory {
 public:
  ElevationMemory(double cell_m, int window_cells);

  /// Moves with the window.
  void move(Scroll scroll);
  void reset();
  /// Begins a row of a frame, in any order of rows.
  void begin_row(int iy);
  /// A cell of that row: m above the frame's plane, and the standard deviation.
  void see(int ix, int iy, float elevation_m, float sigma_m) {
    Range& row{rows_[static_cast<std::size_t>(iy)]};
    row = {std::min(row.begin, ix), std::max(row.end, ix + 1)};
    frame_(ix, iy) = {elevation_m, sigma_m * sigma_m};
  }
  /// Adds the cells of another camera's frame, at the same place of the window.
  void see(const ElevationMemory& other);
  /// Adds the frame.
  void add();
  /// Elevations and their standard deviations, m; NaN: never seen.
  void write(Image<float>& elevation_m, Image<float>& sigma_m) const;

  template <class State>
  void exchange(State& state) {
    state(elevation_m_, variance_);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(elevation_m_, variance_, frame_, rows_, common_);
  }

 private:
  static constexpr float unseen{std::numeric_limits<float>::quiet_NaN()};

  struct Seen {
    float elevation_m{unseen};
    float variance{unseen};
  };
  struct Range {
    int begin;
    int end;
  };
  /// A cell that both memory and frame have, from the middle of the window on.
  struct Common {
    double x;
    double y;
    double difference;
    double variance;
  };
  /// Plane z + x·(ix − middle) + y·(iy − middle), m, and its covariance by rows: z, x, y.
  struct Shift {
    double z, x, y;
    double zz, zx, zy, xx, xy, yy;
  };

  [[nodiscard]] Shift difference(const Shift& expected) const;
  void shift(const Shift& by);

  double cell_m_;
  Image<float> elevation_m_;
  Image<float> variance_;
  Image<Seen> frame_;
  std::vector<Range> rows_;  ///< cells of frame_ that were seen are in these
  std::vector<Common> common_;
};

}  // namespace stereogrid
