// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/matches.hpp"
#include "geometry/road_plane.hpp"
#include "images/patch.hpp"
#include "images/row_alignment/model.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// The right image with its rows where those of the left one are, by linear interpolation between two rows. Above and
/// below the image its first and last row are repeated.
void align_rows(Cpu& cpu, View<const std::uint8_t> right, const RowOffsets& offsets, View<std::uint8_t> aligned);
void align_rows(Reference& reference, View<const std::uint8_t> right, const RowOffsets& offsets,
                View<std::uint8_t> aligned);

/// Row offset measured at a place of the right image.
struct RowSample {
  RowTerms basis;  ///< RowOffsets::basis there
  double offset_px;
  double weight;  ///< 0 … 1: how firmly the patch's texture holds its row
};

/// A sum of weighted equations basis · terms = offset.
struct RowEquations {
  std::array<RowTerms, row_terms> matrix{};
  RowTerms right_side{};

  void add(const RowSample& sample, double weight);
};

/// From one patch to the next, in columns and rows of MatchLattice.
constexpr int alignment_columns{4};
constexpr int alignment_rows{2};

/// Finds the row offsets of a camera in its own matches, frame after frame. Rectified recordings are seldom aligned to
/// better than some tenths of a row, and texture that points at the vanishing point turns each into disparity.
///
/// Offsets of a frame. At a lattice of matched pixels a patch of the left image is tracked in the right one in both
/// directions (Lucas and Kanade 1981, inverse compositional). The fit is robust and weighted by the vertical texture.
/// Frames are combined with exponential decay. One implementation serves every back end: it reads some hundred patches.
class RowAlignment {
 public:
  explicit RowAlignment(const Rig& rig);

  /// Measures one more frame. `right` as it came, not aligned; `matches` found with offsets(); `plane`: the road they
  /// were found with. False where the frame says too little or something incredible: the offsets stay.
  /// `for_ranges(count, work)` calls work(begin, end) on parts of [0, count), on threads of its own if it likes.
  template <class ForRanges>
  bool update(View<const std::uint8_t> left, View<const std::uint8_t> right, const Matches& matches,
              const RoadPlane& plane, const ForRanges& for_ranges) {
    for_ranges(static_cast<int>(rows_.size()), [&](int begin, int end) {
      for (int row{begin}; row < end; ++row) collect(row, left, right, matches, plane);
    });
    return join_frame();
  }
  bool update(View<const std::uint8_t> left, View<const std::uint8_t> right, const Matches& matches,
              const RoadPlane& plane) {
    return update(left, right, matches, plane, [](int count, const auto& work) { work(0, count); });
  }

  /// True if the misalignment is negligible.
  [[nodiscard]] bool is_identity() const { return is_identity_; }
  [[nodiscard]] const RowOffsets& offsets() const { return offsets_; }

  template <class State>
  void exchange(State& state) {
    state(offsets_, remembered_, is_identity_);
  }

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(rows_, samples_); }

 private:
  void collect(int row, View<const std::uint8_t> left, View<const std::uint8_t> right, const Matches& matches,
               const RoadPlane& plane);
  bool join_frame();
  [[nodiscard]] double largest(const RowTerms& terms) const;

  int width_px_;
  int height_px_;
  RowOffsets offsets_;
  RowEquations remembered_;
  bool is_identity_{true};
  std::vector<std::vector<RowSample>> rows_;  ///< by row of patches
  std::vector<RowSample> samples_;            ///< all of them
};

}  // namespace stereogrid
