// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matching/matches.hpp"

namespace stereogrid {

/// Removes connected patches (neighbours of the same label, disparities within 1 px) of few pixels. Works on runs of
/// pixels in a row, of which there are far fewer than pixels.
class Speckles {
 public:
  Speckles(int width, int height);

  /// Patches of fewer than `speckle_px` pixels go.
  void remove(int speckle_px, Matches& matches);

 private:
  struct Run {
    int row;
    int begin;
    int end;
    int parent;  ///< another run of the patch; −(its pixels) in the run that stands for the patch
  };

  void find_runs(int v);
  void join_rows(std::size_t first_above, std::size_t first);
  int find(int run);
  void join(int a, int b);

  int width_;
  std::vector<Run> runs_;
  std::vector<float> labelled_, labelled_above_;  ///< rows of flag_surfaces
  std::vector<std::uint8_t> flags_;
};

}  // namespace stereogrid
