// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "geometry/window.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"
#include "terrain/rules.hpp"

namespace stereogrid {

/// When and from where the cells of the filter's window have last been seen as ground, and where an edge has been seen
/// since. Obstacles and hidden ground end both (docs/terrain.md, "Free has a witness").
class GroundWitness {
 public:
  /// Ground is a witness for `memory_s` seconds.
  GroundWitness(double memory_s, int window_cells)
      : memory_s_{static_cast<float>(memory_s)},
        left_s_{window_cells, window_cells},
        from_m_{window_cells, window_cells} {}

  /// Moves with the window and lets time pass.
  void move(Scroll scroll, double dt_s) {
    scroll_cells(scroll, left_s_);
    scroll_cells(scroll, from_m_);
    const auto passed_s{static_cast<float>(dt_s)};
    float* const left_s{left_s_.data()};
    for (std::size_t i{0}; i < left_s_.size(); ++i)
      left_s[i] = std::max(left_s[i] - passed_s, std::min(left_s[i], 0.0f));
  }
  /// Ground, seen from that distance.
  void see(int ix, int iy, float from_m) {
    left_s_(ix, iy) = memory_s_;
    from_m_(ix, iy) = from_m;
  }
  /// Cells [begin, end) of a row.
  void drop(int iy, int begin, int end) { std::fill(left_s_.row(iy) + begin, left_s_.row(iy) + end, 0.0f); }
  void drop_edges(int iy, int begin, int end) {
    float* const row{left_s_.row(iy)};
    std::transform(row + begin, row + end, row + begin, [](float left_s) { return std::max(left_s, 0.0f); });
  }
  void see_edge(int iy, int begin, int end) { std::fill(left_s_.row(iy) + begin, left_s_.row(iy) + end, edge); }
  void reset() { left_s_.fill(0); }
  /// Cells outside the window have never been seen.
  [[nodiscard]] bool has(int ix, int iy) const {
    return ix >= 0 && iy >= 0 && ix < left_s_.width() && iy < left_s_.height() && left_s_(ix, iy) > 0;
  }
  /// Distance from which the cell was seen.
  [[nodiscard]] float from_m(int ix, int iy) const { return from_m_(ix, iy); }
  [[nodiscard]] bool is_edge(int ix, int iy) const { return left_s_(ix, iy) < 0; }
  /// Cells without a witness are at least unknown.
  void bound(Image<std::uint8_t>& bounds) const {
    std::ranges::transform(left_s_, bounds.begin(),
                           [](float left_s) { return left_s > 0 ? std::uint8_t{0} : std::uint8_t{bound_unknown}; });
  }
  /// Calls work(ix, iy) for the cells with an edge.
  template <class Work>
  void for_edges(const Work& work) const {
    for_used(0, left_s_.height(), [&](int ix, int iy, float left_s) {
      if (left_s < 0) work(ix, iy);
    });
  }
  /// Calls work(ix, iy) for the cells of rows begin … end − 1 that have been seen.
  template <class Work>
  void for_seen(int begin, int end, const Work& work) const {
    for_used(begin, end, [&](int ix, int iy, float left_s) {
      if (left_s > 0) work(ix, iy);
    });
  }
  /// Seconds since the cell was seen; infinite: none that count.
  [[nodiscard]] float age_s(int ix, int iy) const {
    return has(ix, iy) ? memory_s_ - left_s_(ix, iy) : std::numeric_limits<float>::infinity();
  }

  template <class State>
  void exchange(State& state) {
    state(left_s_, from_m_);
  }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(left_s_, from_m_); }

 private:
  static constexpr float edge{-1};

  // Calls work(ix, iy, left_s) for the cells that have been seen or have an edge, and some others.
  template <class Work>
  void for_used(int begin, int end, const Work& work) const {
    for (int iy{begin}; iy < end; ++iy) {
      const float* const row{left_s_.row(iy)};
      const auto is_empty = [row](int first) { return !any_of_group(first, [row](int ix) { return row[ix] != 0; }); };
      for_groups(left_s_.width(), is_empty, [&](int ix) { work(ix, iy, row[ix]); });
    }
  }

  float memory_s_;
  Image<float> left_s_;  ///< seconds that the witness still counts; 0: none; `edge`: an edge
  Image<float> from_m_;  ///< see from_m()
};

}  // namespace stereogrid
