// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "images/patch.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Finds the lowest rows of the level image that show the vehicle itself, such as its bonnet: their texture stays while
/// the vehicle travels. In one frame a bonnet may have the shape of ground.
class OwnSurface {
 public:
  explicit OwnSurface(const Rig& level_rig);

  /// Compares the image with that of half a metre ago. `masked`: see MatchedFrame. `place`: of the vehicle in the
  /// world, m. Returns true where the first row changes, and in the first frame where it is continued.
  bool update(View<const std::uint8_t> left, View<const std::uint8_t> masked, Point2 place);
  /// First row of the vehicle; the image's height: none.
  [[nodiscard]] int first_row() const { return first_row_; }
  [[nodiscard]] bool is_in_view() const { return first_row_ < rig_.height_px; }
  /// Continues that of images whose camera is pitched down by `pitch_rad` more than that of these.
  void continue_from(const OwnSurface& before, double pitch_rad);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(gradients_, rows_, seen_); }

  template <class State>
  void exchange(State& state) {
    const std::size_t pixels{gradients_.size()};
    const std::size_t rows{rows_.size()};
    state(gradients_, rows_, comparisons_, has_reference_, place_, first_row_);
    if constexpr (requires { state.require(true); }) state.require(gradients_.size() == pixels && rows_.size() == rows);
  }

 private:
  /// Textured pixels of a row of the lattice.
  struct Row {
    std::int32_t same{0};     ///< gradients have stayed
    std::int32_t changed{0};  ///< gradients have changed

    void add(const Row& other) {
      same += other.same;
      changed += other.changed;
    }
  };

  void compare(View<const std::uint8_t> left, View<const std::uint8_t> masked);
  [[nodiscard]] int row_of_vehicle() const;

  Rig rig_;
  MatchLattice lattice_;
  std::vector<std::int16_t> gradients_;  ///< reference image, at the lattice
  std::vector<Row> rows_;                ///< sum over the comparisons
  std::vector<Row> seen_;                ///< last comparison
  int comparisons_{0};
  bool has_reference_{false};
  Point2 place_{};  ///< place of the reference image
  int first_row_;
};

/// Adds a warning where the vehicle itself is in view.
void report(const OwnSurface& found, FrameResult& result);

}  // namespace stereogrid
