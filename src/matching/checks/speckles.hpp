// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/matches.hpp"
#include "matching/checks/simd.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// Patches of fewer pixels go, by label.
struct SpeckleSizes {
  int obstacle_px;
  int road_px;

  [[nodiscard]] bool remove_nothing() const { return obstacle_px <= 1 && road_px <= 1; }
};

/// Removes connected patches (neighbours of the same label, disparities within 1 px) of few pixels. Works on runs of
/// pixels in a row, of which there are far fewer than pixels.
class Speckles {
 public:
  Speckles(int width, int height, int bands = 1);

  void remove(const SpeckleSizes& smallest, Matches& matches);

  /// The same in three steps, on bands of rows that follow each other: first `find_patches` for each band, then
  /// `join_bands` once, then `remove_small` for each band. The bands of a step may be worked on at the same time.
  void find_patches(int band, int begin, int end, const Matches& matches);
  void join_bands(const Matches& matches);
  void remove_small(int band, const SpeckleSizes& smallest, Matches& matches) const;

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(bands_) + pixels_ * sizeof(Run); }

 private:
  struct Run {
    int row;
    int begin;
    int end;
    int parent;  ///< another run of the patch; −(its pixels) in the run that stands for the patch
  };
  /// The runs first … end − 1.
  struct Runs {
    int first{0};
    int end{0};
  };
  struct Band {
    int begin_row{0};
    int end_row{0};
    Runs all, first_row, last_row;
    std::vector<float> labelled, labelled_above;  ///< rows of flag_surfaces
    SurfaceBits bits;
    std::vector<std::uint64_t> continues_left_above;  ///< the row above's

    [[nodiscard]] std::size_t memory_bytes() const {
      return memory_bytes_of(labelled, labelled_above, bits.is_measured, bits.continues_left, bits.continues_above,
                             continues_left_above);
    }
  };

  void flag_row(int v, const Matches& matches, Band& band) const;
  void find_runs(int v, Band& band);
  void join_rows(Runs above, Runs here, const Band& band);
  int find(int run);
  void join(int a, int b);

  int width_;
  std::size_t pixels_;
  std::vector<Band> bands_;
  std::unique_ptr<Run[]> runs_;  ///< a place for each pixel: those of row v from v·width on
};

}  // namespace stereogrid
