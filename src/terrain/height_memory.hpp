// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "geometry/window.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Mean heights of cells over the ground around them, and bars, over the frames (docs/terrain.md, "Low obstacles").
/// Heights are in units of what the matcher leaves of a step. Unseen cells keep theirs.
class HeightMemory {
 public:
  /// Samples of full weight: errors of neighbouring pixels are correlated.
  static constexpr int samples_enough{30};
  /// Least mean height of an obstacle.
  static constexpr float obstacle_height{1};
  /// Standard deviations over it of an obstacle, for which cells are many.
  static constexpr float obstacle_sigmas{2};
  /// Standard deviations over it of a sure obstacle: texture almost along the rows has four times the errors.
  static constexpr float sure_sigmas{4};

  /// Mean of a cell with an obstacle.
  struct Mean {
    float height;
    float frames;  ///< its weight relative to the largest one of a frame
    bool is_sure;  ///< sure_sigmas over obstacle_height
  };

  explicit HeightMemory(int window_cells) : cells_{window_cells, window_cells}, tall_{window_cells, window_cells} {}

  /// Adds what a frame has seen. `precision`: step over eight standard deviations of a sample's height; `samples`: up
  /// to samples_enough.
  void add(int ix, int iy, float height, float precision, int samples) {
    const float weight{std::min(precision * precision, weight_max) * static_cast<float>(samples) / samples_enough};
    const bool is_level{height < level_height && weight > level_weight};
    const float kept{is_level ? kept_of_level : kept_of_other};
    Cell& cell{cells_(ix, iy)};
    cell = {kept * cell.weight + weight, kept * cell.weighted + weight * height};
  }
  /// Clears the mean.
  void clear(int ix, int iy) { cells_(ix, iy) = {}; }
  /// Lets a frame pass for bars in view: is_in_view(ix, iy).
  template <class IsInView>
  void pass_bars(const IsInView& is_in_view) {
    for_used(tall_, [&](int ix, int iy, std::uint8_t& tall) {
      if (tall != 0 && is_in_view(ix, iy)) tall = static_cast<std::uint8_t>(tall << 1);
    });
  }
  /// After pass_bars(): the frame has seen something tall.
  void add_tall(int ix, int iy) { tall_(ix, iy) |= 1; }
  [[nodiscard]] bool has_tall(int ix, int iy) const { return tall_(ix, iy) != 0; }
  /// No bar: rays show something.
  void clear_tall(int ix, int iy) { tall_(ix, iy) = 0; }
  void reset() {
    cells_.fill({});
    tall_.fill(0);
  }
  /// Moves with the window.
  void move(Scroll scroll) {
    scroll_cells(scroll, cells_);
    scroll_cells(scroll, tall_);
  }
  /// Calls work(ix, iy, mean) for the cells with an obstacle: its mean is obstacle_sigmas over obstacle_height.
  template <class Work>
  void for_obstacles(const Work& work) const {
    for_used(cells_, [&](int ix, int iy, const Cell& cell) {
      const float weight{cell.weight + prior_weight};
      if (cell.weighted <= obstacle_height * weight) return;
      const float height{cell.weighted / weight};
      const float sigma{height_sigma / std::sqrt(weight)};
      if (height > obstacle_height + obstacle_sigmas * sigma)
        work(ix, iy, Mean{height, cell.weight / weight_max, height > obstacle_height + sure_sigmas * sigma});
    });
  }
  /// Calls work(ix, iy) for the cells with a bar.
  template <class Work>
  void for_bars(const Work& work) const {
    for_used(tall_, [&](int ix, int iy, std::uint8_t tall) {
      if (std::popcount(tall) >= bar_sightings) work(ix, iy);
    });
  }
  template <class State>
  void exchange(State& state) {
    state(cells_, tall_);
  }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(cells_, tall_); }

 private:
  static constexpr float kept_of_other{0.95f};   ///< share per frame that sees the cell
  static constexpr float kept_of_level{0.665f};  ///< share where it sees level ground
  static constexpr float level_height{0.55f};    ///< level: lower than that
  static constexpr float level_weight{0.1f};     ///< a frame with more weight sees the ground
  static constexpr float weight_max{4};          ///< limit per frame: errors of frames are correlated
  static constexpr float prior_weight{0.1f};     ///< weight of level ground before any frame
  static constexpr float height_sigma{0.24f};    ///< noise of a height with weight 1

  static constexpr int bar_sightings{3};  ///< as many of the last eight frames show a bar; two are often wrong matches

  struct Cell {
    float weight{0};
    float weighted{0};
  };

  // All bits of a group's cells are zero.
  template <class T>
  static bool is_empty(const T* cells) {
    constexpr std::size_t words{group_cells * sizeof(T) / sizeof(std::uint64_t)};
    std::uint64_t bits{0};
    for (std::size_t i{0}; i < words; ++i) {
      std::uint64_t word{0};
      std::memcpy(&word, reinterpret_cast<const std::byte*>(cells) + i * sizeof(word), sizeof(word));
      bits |= word;
    }
    return bits == 0;
  }
  // Calls work(ix, iy, cell) for the cells that are not empty, and some others.
  template <class Cells, class Work>
  static void for_used(Cells& cells, const Work& work) {
    for (int iy{0}; iy < cells.height(); ++iy) {
      auto* const row{cells.row(iy)};
      for_groups(
          cells.width(), [row](int first) { return is_empty(row + first); }, [&](int ix) { work(ix, iy, row[ix]); });
    }
  }

  Image<Cell> cells_;
  Image<std::uint8_t> tall_;  ///< the last eight frames with the cell in view that show something tall, lowest bit last
};

}  // namespace stereogrid
