// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "stereogrid/image.hpp"
#include "terrain/model.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

/// Trench of which only the upper part of the far wall is visible, or an edge with lower ground behind it.
struct Trench {
  float edge_x;  ///< last visible ground, m
  float wall_x;  ///< far wall or lower ground, m
  float fall_m;  ///< visible part of the wall, or the fall to the lower ground
  int row;       ///< row of the edge
  float gain;    ///< over ground without it
  float rest_px;
  int chain{1};  ///< number of sectors that have found it

  /// The chain is wide enough to extend it, and to ignore the noise of one sector.
  bool is_sure{false};
};

/// Line with a fall, d = at_edge + growth·k − fall·shape(k), through a sector's rows k around an edge.
struct TrenchFit {
  float at_edge{0};
  float growth{0};
  float fall{0};
  float rest_px{0};
  float gain{0};  ///< over the line alone
};

/// Finds trenches by a matched filter over the rows of a sector (docs/terrain.md, "Trenches").
class TrenchFilter {
 public:
  /// Sectors from one that is searched to the next.
  static constexpr int step{3};

  /// `window_rows`: rows over which the matcher smears a jump.
  TrenchFilter(int height_px, int sectors, int window_rows);

  /// Finds the most certain trench of a sector. Sectors can be searched at the same time.
  void find(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples, int sector);
  /// Finds that of a sector between two that have been searched, near the rows of theirs: their mean disparities are
  /// mostly of the same sectors.
  void find_between(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples,
                    int sector);
  /// Extends long chains of trenches to sectors beside them, once all sectors have been searched.
  void connect(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples);

  [[nodiscard]] const std::optional<Trench>& at(int sector) const { return found_[static_cast<std::size_t>(sector)]; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  struct Search;
  /// Place where most of a fall must be seen.
  struct Probe {
    std::size_t place;
    float along;  ///< place relative to the last one
    float fall;
  };
  /// Fall of the disparity below the ground's line at a far wall, in growths of the disparity per row, after the
  /// matcher's smear. Without wall_rows: 1 on lower ground. The last element is the lowest row.
  struct Shape {
    int wall_rows;
    int edge_place;  ///< element of the edge
    std::vector<float> fall{};
    std::array<Probe, 3> probes{};

    void mark_likely(const Search& search, int first, int end, int bit, int* likely) const;
  };

  [[nodiscard]] std::optional<Trench>& at(int sector) { return found_[static_cast<std::size_t>(sector)]; }
  void place(Search& search, const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples,
             int sector);
  /// Nearest trench to one side of a sector, with its edge near `row`; no_row: in any row.
  [[nodiscard]] Trench* beside(int sector, int side, int reach, int row);
  /// The most certain trench with its edge in rows `lowest` to `highest`, upwards.
  [[nodiscard]] std::optional<Trench> best(const Search& search, int lowest, int highest) const;
  [[nodiscard]] bool is_lower(const Search& search, int edge) const;
  [[nodiscard]] std::optional<Trench> wall(const Search& search, const Shape& shape, int edge) const;
  [[nodiscard]] std::optional<Trench> lower_ground(const Search& search, const Shape& shape, int edge) const;
  [[nodiscard]] static bool is_within(const Search& search, const TrenchFit& fit, float gain, float jump_px);

  Image<float> disparity_;  ///< mean over neighbouring sectors, (row, sector)
  int margin_;              ///< rows of ground on both sides
  std::vector<Shape> shapes_;
  std::vector<std::optional<Trench>> found_;  ///< by sector
};

}  // namespace stereogrid
