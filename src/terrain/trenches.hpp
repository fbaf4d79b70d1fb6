// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "stereogrid/image.hpp"
#include "terrain/model.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

/// Trench of which only the upper part of the far wall is visible.
struct Trench {
  float edge_x;  ///< last visible ground, m
  float wall_x;  ///< far wall, m
  float fall_m;  ///< visible part of the wall
};

/// Finds trenches by a matched filter over the rows of a sector (docs/terrain.md, "Trenches").
class TrenchFilter {
 public:
  /// `window_rows`: rows over which the matcher smears a jump.
  TrenchFilter(int height_px, int sectors, int window_rows);

  /// The most certain trench of a sector. Sectors can be searched at the same time.
  std::optional<Trench> find(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples,
                             int sector);
  [[nodiscard]] std::size_t held_bytes() const;

 private:
  /// Fall of the disparity below the ground's line at a far wall, in growths of the disparity per row, after the
  /// matcher's smear. Element i is `wall_rows + margin − i` rows above the edge.
  struct Shape {
    int wall_rows;
    std::vector<float> fall;
  };

  Image<float> disparity_;  ///< mean over neighbouring sectors, (row, sector)
  int margin_;              ///< rows of ground on both sides
  std::vector<Shape> shapes_;
};

}  // namespace stereogrid
